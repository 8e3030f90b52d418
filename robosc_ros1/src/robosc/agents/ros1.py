"""How an agent's calls go out on ROS 1."""

from __future__ import annotations

from typing import Any

from robosc.agents.outcomes import CallWatch
from robosc.agents.running import End
from robosc.runtime.shortening import Shortener
from robosc.view.ros1 import Ros1
from robosc.view.server import Unable

PATIENCE = 2.0
"""Seconds for which a call waits for its server."""
_LOOK = 0.1
_LEAVING = 5.0
"""Seconds for the end of a goal that was cancelled."""


class Ros1Caller:
    """A :class:`~robosc.agents.running.Caller` beside a listener, which has the node."""

    def __init__(self, listener: Ros1) -> None:
        self._listener = listener

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
        import actionlib
        import rospy
        from actionlib_msgs.msg import GoalStatus

        client, class_ = self._client(name, type_)
        goal = filled(class_().action_goal.goal, data)
        if not client.wait_for_server(rospy.Duration(PATIENCE)):
            raise Unable(f"nobody serves {name}")
        client.send_goal(goal, feedback_cb=lambda told: watch.report(Shortener()(told)))
        left = None
        while not client.wait_for_result(rospy.Duration(_LOOK)):
            if watch.cancelled.is_set() and left is None:
                client.cancel_goal()
                left = _LEAVING
            if left is not None:
                left -= _LOOK
                if left < 0:
                    return "failed", "it was cancelled, and has not ended"
        state, text = client.get_state(), client.get_goal_status_text()
        if state == actionlib.GoalStatus.SUCCEEDED:
            return "answered", Shortener()(client.get_result())
        if state in (GoalStatus.PREEMPTED, GoalStatus.RECALLED):
            return "cancelled", Shortener()(text)
        return "refused" if state == GoalStatus.REJECTED else "failed", Shortener()(text)

    def close(self) -> None:
        self._listener.close()

    def _client(self, name: str, type_: str) -> tuple[Any, Any]:
        import actionlib
        import roslib.message

        class_ = roslib.message.get_message_class(f"{type_.removesuffix('Action')}Action")
        if class_ is None:
            raise Unable(f"this machine has no {type_}: source the workspace that has it")
        return actionlib.SimpleActionClient(name, class_), class_


def filled(message: Any, data: Any) -> Any:
    """A message with these fields.

    Raises:
        Unable: they do not fit.
    """
    import genpy

    try:
        genpy.message.fill_message_args(message, [data])
        message._check_types()
    except (genpy.MessageException, ValueError) as error:
        raise Unable(str(error)) from None
    return message
