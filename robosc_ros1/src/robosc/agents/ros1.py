"""How an agent's calls go out on ROS 1."""

from __future__ import annotations

import threading
from concurrent.futures import Future
from typing import Any

from robosc.agents.running import End, RequestNews
from robosc.view import operating, ros1, server


class Ros1Caller(ros1.Ros1):
    """A :class:`~robosc.agents.running.Caller`."""

    TOPICS = (*ros1.Ros1.TOPICS, "blocked")

    def call(self, name: str, type_: str, data: Any, told: RequestNews) -> End:
        import roslib.message
        import rospy

        class_ = ros1.known_class(roslib.message.get_service_class, type_)
        request = ros1.filled(class_._request_class(), data)
        try:
            rospy.wait_for_service(name, operating.PATIENCE)
        except rospy.ROSException:
            raise server.Unable(f"nobody serves {name}") from None
        answer: Future[End] = Future()

        def ask() -> None:
            try:
                answer.set_result(("answered", rospy.ServiceProxy(name, class_)(request)))
            except (rospy.ROSException, rospy.ServiceException) as error:
                answer.set_result(("failed", str(error)))

        threading.Thread(target=ask, name=name, daemon=True).start()
        return told.wait(answer.done) or answer.result()

    def goal(self, name: str, type_: str, data: Any, told: RequestNews) -> End:
        import actionlib
        import roslib.message
        import rospy
        from actionlib import CommState, TerminalState

        type_ = f"{type_.removesuffix('Action')}Action"
        class_ = ros1.known_class(roslib.message.get_message_class, type_)
        goal = ros1.filled(class_().action_goal.goal, data)
        if name not in self._clients:
            self._clients[name] = actionlib.ActionClient(name, class_)
        if not self._clients[name].wait_for_server(rospy.Duration(operating.PATIENCE)):
            raise server.Unable(f"nobody serves {name}")
        # Not actionlib's simple client: it loses the end of a goal that is rejected at once.
        handle = self._clients[name].send_goal(
            goal, feedback_cb=lambda _, feedback: told.watch.report(feedback)
        )
        ended = told.wait(lambda: handle.get_comm_state() == CommState.DONE, handle.cancel)
        if ended is not None:
            return ended
        state, text = handle.get_terminal_state(), handle.get_goal_status_text()
        if state == TerminalState.SUCCEEDED:
            return "answered", handle.get_result()
        if state in (TerminalState.PREEMPTED, TerminalState.RECALLED):
            return "cancelled", text
        return "refused" if state == TerminalState.REJECTED else "failed", text
