# In no generated package: robosc itself judges recordings with it.
"""What the topics of an action or a service tell to somebody who only listens.

An action of ROS 1 is five topics, which tell everything. One of ROS 2 shows its status and its
feedback: when goals begin and how they end, but neither goals nor results. Services of ROS 2
publish events if that is turned on (service introspection); those of ROS 1 show nothing.
"""

from __future__ import annotations

from typing import Any, Callable, Dict, Tuple

from .calls import Failure
from .monitor_engine import MonitorEngine

Handler = Callable[[Any], None]

_FAILURES = {2: "preempted", 4: "aborted", 5: "rejected", 8: "recalled", 9: "lost by the server"}
"""By the status of actionlib_msgs/GoalStatus."""
_SUCCEEDED = 3
_WITH_RESULT = (2, 4)

_RUNNING_2 = (1, 2, 3)
_CANCELING_2 = 3
_SUCCEEDED_2 = 4
_FAILURES_2 = {5: "canceled", 6: "aborted"}
"""By the status of action_msgs/GoalStatus."""


class SeenAction:
    """An action of ROS 1, by the parts of its name; each handler takes the messages of one."""

    def __init__(self, engine: MonitorEngine, key: str) -> None:
        self._engine = engine
        self._key = key
        self._id = ""
        self._stamp = 0.0
        self._going_on = False
        self._before = ""  # the goal before, if its end was not seen
        self.handlers: Dict[str, Handler] = {
            "/goal": self._goal,
            "/cancel": self._cancel,
            "/feedback": self._feedback,
            "/result": self._result,
        }

    def _goal(self, message: Any) -> None:
        self._before = self._id if self._going_on else ""
        self._id = message.goal_id.id
        self._going_on = True
        self._stamp = _seconds(message.goal_id.stamp) or _seconds(message.header.stamp)
        self._engine.see(self._key, "request", message.goal)

    def _cancel(self, message: Any) -> None:
        """Take a cancel if it is meant for the goal, by the rules of actionlib's ActionServer."""
        stamp = _seconds(message.stamp)
        meant = self._stamp <= stamp if stamp else not message.id
        if self._before and message.id == self._before:
            self._before = ""
        elif message.id == self._id or meant:
            self._going_on = False
        else:
            return
        self._engine.see(self._key, "cancel")

    def _feedback(self, message: Any) -> None:
        self._answer(message, "feedback", message.feedback)

    def _result(self, message: Any) -> None:
        status = message.status.status
        if status == _SUCCEEDED:
            self._answer(message, "response", message.result)
        else:
            reason = _FAILURES.get(status, "ended without result")
            result = message.result if status in _WITH_RESULT else None
            self._answer(message, "error", Failure(reason, result))

    def _answer(self, message: Any, kind: str, payload: Any) -> None:
        goal = message.status.goal_id.id
        former = bool(self._before) and goal == self._before
        # A server chooses the id of a goal without one.
        if not former and self._id and goal != self._id:
            return
        if kind != "feedback":
            if former:
                self._before = ""
            else:
                self._going_on = False
        self._engine.answer(self._key, kind, payload, former)


class SeenActionOfRos2:
    """An action of ROS 2, by the parts of its name."""

    def __init__(self, engine: MonitorEngine, key: str) -> None:
        self._engine = engine
        self._key = key
        self._last: Dict[bytes, int] = {}
        self.handlers: Dict[str, Handler] = {
            "/_action/status": self._status,
            "/_action/feedback": self._feedback,
        }

    def _status(self, message: Any) -> None:
        before, self._last = self._last, {}
        # Those that began go last: others end before.
        for one in sorted(message.status_list, key=lambda one: _goal_of(one) not in before):
            goal, status = _goal_of(one), one.status
            self._last[goal] = status
            old = before.get(goal)
            if old == status or (old is None and status not in _RUNNING_2):
                continue  # it ended before anybody listened
            if old is None:
                self._engine.see(self._key, "request")
            if status == _CANCELING_2:
                self._engine.see(self._key, "cancel")
            elif status == _SUCCEEDED_2:
                self._engine.answer(self._key, "response")
            elif status in _FAILURES_2:
                self._engine.answer(self._key, "error", Failure(_FAILURES_2[status]))

    def _feedback(self, message: Any) -> None:
        self._engine.answer(self._key, "feedback", message.feedback)


class SeenServiceOfRos2:
    """A service of ROS 2 whose events are published; client and server may both do so."""

    def __init__(self, engine: MonitorEngine, key: str) -> None:
        self._engine = engine
        self._key = key
        self._calls: Dict[Tuple[bytes, int], bool] = {}  # whether it was answered
        self.handlers: Dict[str, Handler] = {"/_service_event": self._event}

    def _event(self, message: Any) -> None:
        info = message.info
        call = bytes(info.client_gid), info.sequence_number
        is_request = info.event_type in (0, 1)
        if is_request and call not in self._calls:
            self._calls = {known: ended for known, ended in self._calls.items() if not ended}
            self._calls[call] = False
            self._engine.see(self._key, "request", next(iter(message.request), None))
        elif not is_request and not self._calls.get(call, True):
            self._calls[call] = True
            self._engine.answer(self._key, "response", next(iter(message.response), None))


def _goal_of(status: Any) -> bytes:
    return bytes(status.goal_info.goal_id.uuid)


def _seconds(stamp: Any) -> float:
    """Return a time of ROS 1 in seconds."""
    return float(stamp.secs + stamp.nsecs * 1e-9)
