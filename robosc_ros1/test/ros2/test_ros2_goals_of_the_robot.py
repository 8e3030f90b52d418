"""Actions of a generated controller on real rclpy: each goal is answered once, or rejected."""

from __future__ import annotations

from collections.abc import Callable

import pytest
from ros2.ros2_support import Graph, Peer, Process

Start = Callable[..., Process]
NODE, NAME = "missions_controller", "/mission"
TYPE = "robot_common/action/Order"
SUCCEEDED, CANCELED, ABORTED = 4, 5, 6


@pytest.fixture
def robot(graph: Graph, controller: Start) -> Peer:
    controller(NODE, qos__step__reliability="reliable", qos__fault__reliability="reliable")
    peer = graph.peer()
    peer.watch(NODE)
    return peer


def send(peer: Peer, x: float = 2.5) -> str:
    goal: str = peer.order("send_goal", name=NAME, type=TYPE, data={"x": [x], "y": [0.0]})
    return goal


def accepted(peer: Peer) -> str:
    goal = send(peer)
    assert peer.expect("answer", id=goal)["accepted"]
    return goal


def step(robot: Peer, number: int) -> None:
    robot.publish("/step", "std_msgs/msg/Int16", {"data": number})


def test_a_goal_is_reported_on_and_answered(robot: Peer) -> None:
    goal = accepted(robot)
    step(robot, 2)
    report = robot.expect("feedback", id=goal, where=lambda data: data["reached"] == 2)
    assert report["data"]["distance"] == 2.5
    step(robot, 3)
    ended = robot.expect("result", id=goal)
    assert (ended["status"], ended["data"]["reached"]) == (SUCCEEDED, 3)
    assert robot.expect("result", id=accepted(robot))["status"] == SUCCEEDED


def test_what_is_not_taken_is_rejected(graph: Graph, robot: Peer) -> None:
    assert not robot.expect("answer", id=send(robot, -1.0))["accepted"]
    goal = accepted(robot)
    other = graph.peer()
    assert not other.expect("answer", id=send(other))["accepted"]
    robot.expect_state(NODE, lambda s: s["counters"]["refused"] == 2)
    step(robot, 3)
    assert robot.expect("result", id=goal)["status"] == SUCCEEDED


def test_a_cancelled_goal_ends_as_the_controller_says(robot: Peer) -> None:
    goal = accepted(robot)
    robot.order("cancel_goal", id=goal)
    ended = robot.expect("result", id=goal)
    assert ended["status"] == CANCELED
    assert "Missions is in leaving" in ended["data"]["message"]
    robot.expect_state(NODE, lambda s: s["communications"]["mission"] == "idle")


def test_an_error_of_the_controller_aborts_the_goal(robot: Peer) -> None:
    goal = accepted(robot)
    robot.publish("/fault", "std_msgs/msg/Bool", {"data": True})
    ended = robot.expect("result", id=goal)
    assert ended["status"] == ABORTED
    assert "Missions is in running" in ended["data"]["message"]


def test_whoever_is_killed_leaves_the_action_to_others(graph: Graph, robot: Peer) -> None:
    caller = graph.peer()
    accepted(caller)
    caller.process.popen.kill()
    caller.process.popen.wait()
    step(robot, 3)
    robot.expect_state(NODE, lambda s: s["communications"]["mission"] == "idle")
    assert robot.expect("result", id=accepted(robot))["status"] == SUCCEEDED
