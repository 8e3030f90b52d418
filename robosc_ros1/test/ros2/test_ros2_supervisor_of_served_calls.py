"""A supervisor between a robot that calls and the generated controller that answers, on rclpy."""

from __future__ import annotations

from collections.abc import Callable

import pytest
from ros2.ros2_support import Graph, Peer, Process
from ros2.test_ros2_calls_of_the_robot import DONE, ORDER, call, open_door
from ros2.test_ros2_goals_of_the_robot import (
    ABORTED,
    CANCELED,
    SUCCEEDED,
    accepted,
    send,
    step,
)

Guarded = Callable[[str], dict[str, Process]]


@pytest.fixture
def robot(graph: Graph) -> Peer:
    return graph.peer()


def start(robot: Peer, guarded: Guarded, model: str) -> dict[str, Process]:
    """The supervisor and the controller that is guarded, both of them watched."""
    nodes = guarded(model)
    for node in nodes:
        robot.watch(node)
    return nodes


def test_a_call_is_answered_by_the_controller(graph: Graph, robot: Peer, guarded: Guarded) -> None:
    start(robot, guarded, "orders")
    peer = graph.peer()
    peer.order("start_call", name=ORDER, type="std_srvs/srv/SetBool", data={"data": True})
    for node in ("orders_controller", "orders_supervisor"):
        robot.expect_state(node, lambda s: s["communications"]["order"] == "busy")
    assert "order is busy" in call(graph.peer(), ORDER, True)["message"]
    open_door(robot)
    assert peer.expect("response", name=ORDER)["data"] == DONE
    refused = call(peer, ORDER, False)
    assert not refused["success"] and "Orders in unwanted" in refused["message"]
    assert call(peer, ORDER, True) == DONE


def test_a_goal_of_the_robot(robot: Peer, guarded: Guarded) -> None:
    start(robot, guarded, "missions")
    goal = accepted(robot)
    robot.expect_state("missions_controller", lambda s: s["communications"]["mission"] == "busy")
    step(robot, 2)
    robot.expect("feedback", id=goal, where=lambda data: data["reached"] == 2)
    step(robot, 3)
    ended = robot.expect("result", id=goal)
    assert (ended["status"], ended["data"]["reached"]) == (SUCCEEDED, 3)
    step(robot, 0)
    robot.expect_state("missions_controller", lambda s: s["variables"]["Legs.steps"] == 0)
    goal = accepted(robot)
    robot.expect_state("missions_controller", lambda s: s["communications"]["mission"] == "busy")
    robot.order("cancel_goal", id=goal)
    assert robot.expect("result", id=goal)["status"] == CANCELED
    robot.expect_state("missions_supervisor", lambda s: s["communications"]["mission"] == "idle")
    assert not robot.expect("answer", id=send(robot, -1.0))["accepted"]


@pytest.mark.once
def test_the_controller_is_killed(robot: Peer, guarded: Guarded) -> None:
    controller = start(robot, guarded, "missions")["missions_controller"]
    goal = accepted(robot)
    robot.expect_state("missions_controller", lambda s: s["communications"]["mission"] == "busy")
    controller.popen.kill()
    ended = robot.expect("result", id=goal)
    assert ended["status"] == ABORTED and "lost" in ended["data"]["message"]


def test_whoever_is_killed_leaves_the_action_to_others(
    graph: Graph, robot: Peer, guarded: Guarded
) -> None:
    start(robot, guarded, "missions")
    caller = graph.peer()
    accepted(caller)
    robot.expect_state("missions_controller", lambda s: s["communications"]["mission"] == "busy")
    caller.process.popen.kill()
    caller.process.popen.wait()
    step(robot, 3)
    are_idle(robot)
    assert robot.expect("result", id=accepted(robot))["status"] == SUCCEEDED


def test_cancels_at_once(robot: Peer, guarded: Guarded) -> None:
    start(robot, guarded, "missions")
    for _ in range(20):
        goal = accepted(robot)
        robot.begin("cancel_goal", id=goal)
        assert robot.expect("result", id=goal)["status"] == CANCELED
    are_idle(robot)


def are_idle(robot: Peer) -> None:
    for node in ("missions_controller", "missions_supervisor"):
        robot.expect_state(node, lambda s: s["communications"]["mission"] == "idle")
