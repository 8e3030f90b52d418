"""Whoever calls is killed in each phase of its call; the controller serves the next one."""

from __future__ import annotations

import pytest
from actionlib_msgs.msg import GoalStatus
from ros1.stage import Node, Puppet, Stage
from ros1.test_calls_of_the_robot import BOOL, DONE, ORDER, call
from ros1.test_goals_of_the_robot import GOAL, NAME, TYPE, end, send, step
from ros_support import await_condition


def reach(nodes: tuple[Node, ...], name: str, phase: str) -> None:
    for node in nodes:
        node.shows(lambda s: s["communications"][name] == phase, since=node.ear.mark)


@pytest.mark.parametrize("model", ["orders"])
@pytest.mark.parametrize("phase", ["sent", "busy"])
def test_callers(
    stage: Stage, puppet: Puppet, nodes: tuple[Node, ...], model: str, phase: str
) -> None:
    with stage.puppet() as caller:
        caller.do("call", **ORDER, fields={"data": True})
        if phase == "busy":
            reach(nodes, "order", "busy")
        caller.process.kill()
    puppet.publish("/door", BOOL, True)
    # The call of the one that was killed may be under way.
    await_condition(lambda: call(puppet, ORDER, True).get("message") == DONE, "the next call")
    reach(nodes, "order", "idle")


@pytest.mark.parametrize("model", ["missions"])
@pytest.mark.parametrize("phase", ["sent", "busy", "reported", "cancelled", "ending", "ended"])
def test_senders_of_goals(
    stage: Stage, puppet: Puppet, nodes: tuple[Node, ...], model: str, phase: str
) -> None:
    with stage.puppet() as caller:
        mark = caller.mark
        caller.do("send", name=NAME, type=TYPE, fields=GOAL)
        if phase != "sent":
            reach(nodes, "mission", "busy")
        if phase == "reported":
            step(puppet, 2)
            caller.wait(
                lambda line: line.get("progress") == NAME and line["message"]["reached"] == 2,
                "feedback", since=mark,
            )  # fmt: skip
        if phase == "cancelled":
            caller.begin("cancel")
        if phase == "ending":
            caller.do("cancel")
        if phase == "ended":
            step(puppet, 3)
        caller.process.kill()
    step(puppet, 3)

    def succeeds() -> bool:
        status: int = end(puppet, send(puppet))["status"]
        assert status in (GoalStatus.SUCCEEDED, GoalStatus.REJECTED)
        return status == GoalStatus.SUCCEEDED

    # The goal of the one that was killed may be under way.
    await_condition(succeeds, "the next goal")
    reach(nodes, "mission", "idle")
