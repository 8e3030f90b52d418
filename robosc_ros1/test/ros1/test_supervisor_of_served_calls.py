"""A supervisor between a robot that calls and the generated controller that answers, on a roscore."""

from __future__ import annotations

from typing import Any

import pytest
from actionlib_msgs.msg import GoalStatus
from ros1.stage import Node, Puppet, Stage
from ros1.test_calls_of_the_robot import DONE, ORDER, call
from ros1.test_goals_of_the_robot import end, send

BOOL = "std_msgs/Bool"


def is_busy(node: Node, name: str) -> dict[str, Any]:
    return node.shows(lambda s: s["communications"][name] == "busy", since=node.ear.mark)


def test_a_call_is_answered_by_the_controller(stage: Stage, puppet: Puppet, ear: Puppet) -> None:
    with stage.guarded(ear, "orders") as (supervisor, controller):
        mark = puppet.mark
        puppet.do("call", **ORDER, fields={"data": True})
        is_busy(supervisor, "order")
        is_busy(controller, "order")
        with stage.puppet() as other:
            assert "order is busy" in call(other, ORDER, True)["failure"]
        puppet.publish("/door", BOOL, True)
        answered = puppet.wait(lambda line: line.get("answered") == "/order", "it", since=mark)
        assert answered["message"] == DONE
        assert "Orders is in unwanted" in call(puppet, ORDER, False)["failure"]
        assert call(puppet, ORDER, True)["message"] == DONE
        state = supervisor.shows(lambda s: s["counters"]["refused"] == 1)
        assert state["counters"]["blocked"] == 0


def test_a_goal_of_the_robot(stage: Stage, puppet: Puppet, ear: Puppet) -> None:
    with stage.guarded(ear, "missions") as (supervisor, controller):
        mark = send(puppet)
        is_busy(controller, "mission")
        puppet.publish("/step", "std_msgs/Int16", 2)
        report = puppet.wait(
            lambda line: line.get("progress") == "/mission" and line["message"]["reached"] == 2,
            "feedback", since=mark,
        )  # fmt: skip
        assert report["message"]["distance"] == 2.5
        puppet.publish("/step", "std_msgs/Int16", 3)
        ended = end(puppet, mark)
        assert (ended["status"], ended["result"]["reached"]) == (GoalStatus.SUCCEEDED, 3)
        puppet.publish("/step", "std_msgs/Int16", 0)
        mark = send(puppet)
        is_busy(controller, "mission")
        puppet.do("cancel")
        ended = end(puppet, mark)
        assert ended["status"] == GoalStatus.PREEMPTED and "Missions is in leaving" in ended["text"]
        supervisor.shows(lambda s: s["communications"]["mission"] == "idle", since=ear.mark)
        refused = end(puppet, send(puppet, x=[-1.0]))
        assert refused["status"] == GoalStatus.REJECTED


@pytest.mark.once
def test_the_controller_is_killed(stage: Stage, puppet: Puppet, ear: Puppet) -> None:
    with stage.guarded(ear, "missions") as (_, controller):
        mark = send(puppet)
        ear.sees_a_goal_run("/supervised/mission")
        controller.process.kill()
        ended = end(puppet, mark)
        assert ended["status"] == GoalStatus.ABORTED and "lost" in ended["text"]
