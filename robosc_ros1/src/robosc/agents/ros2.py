"""How an agent's calls go out on ROS 2."""

from __future__ import annotations

import runpy
from collections.abc import Callable
from functools import cache, partial
from typing import Any

from robosc.agents.running import End, RequestNews
from robosc.resources import templates_folder
from robosc.view import operating, ros2, server


class Ros2Caller(ros2.Ros2):
    """A :class:`~robosc.agents.running.Caller`; the listener's thread turns the node."""

    TOPICS = (*ros2.Ros2.TOPICS, "blocked")

    def call(self, name: str, type_: str, data: Any, told: RequestNews) -> End:
        class_ = ros2.known_class(type_, "srv")
        request = ros2.filled(class_.Request, data)
        client = self._client(name, self.node.create_client, class_)
        if not client.wait_for_service(operating.PATIENCE):
            raise server.Unable(f"nobody serves {name}")
        answer = client.call_async(request)
        ended = told.wait(answer.done)
        if ended is not None:
            client.remove_pending_request(answer)
            return ended
        return "answered", answer.result()

    def goal(self, name: str, type_: str, data: Any, told: RequestNews) -> End:
        from action_msgs.msg import GoalStatus

        class_ = ros2.known_class(type_, "action")
        goal = ros2.filled(class_.Goal, data)
        client = self._client(name, partial(action_client(), self.node), class_)
        if not client.wait_for_server(operating.PATIENCE):
            raise server.Unable(f"nobody serves {name}")
        report = told.watch.report
        sending = client.ask(
            lambda: client.send_goal_async(goal, lambda message: report(message.feedback))
        )
        # One that is cancelled so soon is cancelled below, once it is accepted.
        ended = told.wait(sending.done, lambda: None)
        if ended is not None:
            return ended
        handle = sending.result()
        if not handle.accepted:
            return "refused", "the goal was rejected"
        ending = client.ask(handle.get_result_async)
        ended = told.wait(ending.done, lambda: client.ask(handle.cancel_goal_async))
        if ended is not None:
            return ended
        status, answer = ending.result().status, ending.result().result
        if status == GoalStatus.STATUS_SUCCEEDED:
            return "answered", answer
        return "cancelled" if status == GoalStatus.STATUS_CANCELED else "failed", answer

    def _client(self, name: str, make: Callable[[Any, str], Any], class_: Any) -> Any:
        if name not in self._clients:
            self._clients[name] = make(class_, name)
        return self._clients[name]


@cache
def action_client() -> Any:
    """The client of actions that loses no answer, which the tests of packages have."""
    return runpy.run_path(str(templates_folder() / "ros2" / "action_client.py"))["Client"]
