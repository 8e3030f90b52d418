"""How an agent's calls go out on ROS 2."""

from __future__ import annotations

import importlib
import time
from typing import Any

from robosc.agents.outcomes import CallWatch
from robosc.agents.running import End
from robosc.runtime.shortening import Shortener
from robosc.view.ros2 import Ros2, filled
from robosc.view.server import Unable

PATIENCE = 2.0
"""Seconds for which a call waits for its server."""
_LOOK = 0.02
_LEAVING = 5.0
"""Seconds for the end of a goal that was cancelled."""


class Ros2Caller:
    """A :class:`~robosc.agents.running.Caller` beside a listener, whose thread turns the node."""

    def __init__(self, listener: Ros2) -> None:
        self._listener = listener
        self._clients: dict[str, Any] = {}

    def publish(self, topic: str, data: Any) -> None:
        self._listener.publish(topic, data)

    def call(self, name: str, type_: str, data: Any, watch: CallWatch) -> End:
        class_ = _class(type_, "srv")
        client = self._clients.get(name)
        if client is None:
            client = self._clients[name] = self._listener.node.create_client(class_, name)
        request = _filled(class_.Request, data)
        if not client.wait_for_service(PATIENCE):
            raise Unable(f"nobody serves {name}")
        future = client.call_async(request)
        while not future.done():
            if watch.cancelled.is_set():
                client.remove_pending_request(future)
                return "failed", "nobody waits for the answer any more"
            time.sleep(_LOOK)
        return "answered", Shortener()(future.result())

    def goal(self, name: str, type_: str, data: Any, watch: CallWatch) -> End:
        from action_msgs.msg import GoalStatus
        from rclpy.action import ActionClient

        class_ = _class(type_, "action")
        client = self._clients.get(name)
        if client is None:
            client = self._clients[name] = ActionClient(self._listener.node, class_, name)
        goal = _filled(class_.Goal, data)
        if not client.wait_for_server(PATIENCE):
            raise Unable(f"nobody serves {name}")
        sending = client.send_goal_async(
            goal, feedback_callback=lambda told: watch.report(Shortener()(told.feedback))
        )
        if not _done(sending, _LEAVING):
            return "failed", "nobody said whether the goal is accepted; it may still run"
        handle = sending.result()
        if not handle.accepted:
            return "refused", "the goal was rejected"
        ending = handle.get_result_async()
        asked = None
        while not ending.done():
            if watch.cancelled.is_set() and asked is None:
                handle.cancel_goal_async()
                asked = time.monotonic()
            if asked is not None and time.monotonic() - asked > _LEAVING:
                return "failed", "it was cancelled, and has not ended"
            time.sleep(_LOOK)
        result = ending.result()
        answer = Shortener()(result.result)
        if result.status == GoalStatus.STATUS_SUCCEEDED:
            return "answered", answer
        return "cancelled" if result.status == GoalStatus.STATUS_CANCELED else "failed", answer

    def close(self) -> None:
        self._listener.close()


def _done(future: Any, timeout: float) -> bool:
    end = time.monotonic() + timeout
    while not future.done() and time.monotonic() < end:
        time.sleep(_LOOK)
    return bool(future.done())


def _class(type_: str, kind: str) -> Any:
    package, _, name = type_.partition("/")
    try:
        return getattr(importlib.import_module(f"{package}.{kind}"), name)
    except (ImportError, AttributeError):
        raise Unable(f"this machine has no {type_}: source the workspace that has it") from None


def _filled(class_: Any, data: Any) -> Any:
    try:
        return filled(class_, data)
    except (AssertionError, AttributeError, OverflowError, TypeError, ValueError) as error:
        raise Unable(f"this does not fit {class_.__name__}: {error}") from None
