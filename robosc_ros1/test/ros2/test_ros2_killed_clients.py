"""Whoever calls is killed in each phase of its call; the controller serves the next one."""

from __future__ import annotations

import pytest
from ros2.ros2_support import Graph, Peer, Process
from ros2.test_ros2_calls_of_the_robot import DONE, ORDER, call, open_door
from ros2.test_ros2_calls_of_the_robot import TYPE as SWITCH
from ros2.test_ros2_goals_of_the_robot import SUCCEEDED, send, step
from ros_support import await_condition


def reach(robot: Peer, nodes: dict[str, Process], name: str, phase: str) -> None:
    for node in nodes:
        robot.expect_state(node, lambda s: s["communications"][name] == phase)


def kill(peer: Peer) -> None:
    peer.process.popen.kill()
    peer.process.popen.wait()


@pytest.mark.parametrize("model", ["orders"])
@pytest.mark.parametrize("phase", ["sent", "busy"])
def test_callers(
    graph: Graph, watcher: Peer, nodes: dict[str, Process], model: str, phase: str
) -> None:
    robot, caller = watcher, graph.peer()
    caller.order("start_call", name=ORDER, type=SWITCH, data={"data": True})
    if phase == "busy":
        reach(robot, nodes, "order", "busy")
    kill(caller)
    open_door(robot)
    # The call of the one that was killed may be under way.
    await_condition(lambda: call(robot, ORDER, True) == DONE, "the next call")
    reach(robot, nodes, "order", "idle")


@pytest.mark.parametrize("model", ["missions"])
@pytest.mark.parametrize("phase", ["sent", "busy", "reported", "cancelled", "ending", "ended"])
def test_senders_of_goals(
    graph: Graph, watcher: Peer, nodes: dict[str, Process], model: str, phase: str
) -> None:
    robot, caller = watcher, graph.peer()
    goal = send(caller)
    if phase != "sent":
        assert caller.expect("answer", id=goal)["accepted"]
        reach(robot, nodes, "mission", "busy")
    if phase == "reported":
        step(robot, 2)
        caller.expect("feedback", id=goal, where=lambda data: data["reached"] == 2)
    if phase == "cancelled":
        caller.begin("cancel_goal", id=goal)
    if phase == "ending":
        caller.order("cancel_goal", id=goal)
    if phase == "ended":
        step(robot, 3)
    kill(caller)
    step(robot, 3)

    def succeeds() -> bool:
        following = send(robot)
        if not robot.expect("answer", id=following)["accepted"]:
            return False
        assert robot.expect("result", id=following)["status"] == SUCCEEDED
        return True

    # The goal of the one that was killed may be under way.
    await_condition(succeeds, "the next goal")
    reach(robot, nodes, "mission", "idle")
