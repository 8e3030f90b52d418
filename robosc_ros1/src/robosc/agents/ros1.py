"""How an agent's calls go out on ROS 1."""

from __future__ import annotations

import time
from typing import Any

from robosc.agents.outcomes import CallWatch
from robosc.agents.running import End
from robosc.runtime.shortening import Shortener
from robosc.view.ros1 import Ros1, filled
from robosc.view.server import Unable

PATIENCE = 2.0
"""Seconds for which a call waits for its server."""
_LOOK = 0.02
_LEAVING = 5.0
"""Seconds for the end of a goal that was cancelled."""


class Ros1Caller:
    """A :class:`~robosc.agents.running.Caller` beside a listener, which has the node."""

    def __init__(self, listener: Ros1) -> None:
        self._listener = listener
        self._clients: dict[str, Any] = {}

    def publish(self, topic: str, data: Any) -> None:
        self._listener.publish(topic, data)

    def call(self, name: str, type_: str, data: Any, watch: CallWatch) -> End:
        import roslib.message
        import rospy

        class_ = roslib.message.get_service_class(type_)
        if class_ is None:
            raise Unable(f"this machine has no {type_}: source the workspace that has it")
        request = filled(class_._request_class(), data)
        try:
            rospy.wait_for_service(name, PATIENCE)
            answer = rospy.ServiceProxy(name, class_)(request)
        except (rospy.ROSException, rospy.ServiceException) as error:
            return "failed", str(error)
        return "answered", Shortener()(answer)

    def goal(self, name: str, type_: str, data: Any, watch: CallWatch) -> End:
        import rospy
        from actionlib import CommState, TerminalState

        client, class_ = self._client(name, type_)
        goal = filled(class_().action_goal.goal, data)
        if not client.wait_for_server(rospy.Duration(PATIENCE)):
            raise Unable(f"nobody serves {name}")
        # Not actionlib's simple client: it loses the end of a goal that is rejected at once.
        handle = client.send_goal(goal, feedback_cb=lambda _, told: watch.report(Shortener()(told)))
        left = None
        while handle.get_comm_state() != CommState.DONE:
            time.sleep(_LOOK)
            if watch.cancelled.is_set() and left is None:
                handle.cancel()
                left = _LEAVING
            if left is not None:
                left -= _LOOK
                if left < 0:
                    return "failed", "it was cancelled, and has not ended"
        state, text = handle.get_terminal_state(), handle.get_goal_status_text()
        if state == TerminalState.SUCCEEDED:
            return "answered", Shortener()(handle.get_result())
        if state in (TerminalState.PREEMPTED, TerminalState.RECALLED):
            return "cancelled", Shortener()(text)
        return "refused" if state == TerminalState.REJECTED else "failed", Shortener()(text)

    def close(self) -> None:
        self._listener.close()

    def _client(self, name: str, type_: str) -> tuple[Any, Any]:
        import actionlib
        import roslib.message

        class_ = roslib.message.get_message_class(f"{type_.removesuffix('Action')}Action")
        if class_ is None:
            raise Unable(f"this machine has no {type_}: source the workspace that has it")
        if name not in self._clients:
            self._clients[name] = actionlib.ActionClient(name, class_)
        return self._clients[name], class_
