"""Actions of a generated controller on real rclpy: each goal is answered once, or rejected."""

from __future__ import annotations

import json
import signal
from collections.abc import Callable
from typing import Any

import pytest
from ros2.bed import HERE
from ros2.conftest import Built
from ros2.ros2_support import Graph, Peer, Process
from ros2.test_ros2_lifecycle import ACTIVATE, CONFIGURE, DEACTIVATE, change

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


def is_over(state: dict[str, Any]) -> bool:
    """Whether a goal has come, and none runs any more."""
    has_come = any(told["event"]["name"] == "mission" for told in state["latest"])
    return has_come and state["communications"]["mission"] == "idle"


def step(robot: Peer, number: int) -> None:
    robot.publish("/step", "std_msgs/msg/Int16", {"data": number})


def is_enabled(state: dict[str, Any], kind: str) -> bool:
    told = ({"kind": kind, "name": "mission", "value": None}, True)
    return told in [(command["event"], command["enabled"]) for command in state["commands"]]


@pytest.mark.once
def test_a_goal_is_reported_on_and_answered(robot: Peer) -> None:
    goal = accepted(robot)
    step(robot, 2)
    report = robot.expect("feedback", id=goal, where=lambda data: data["reached"] == 2)
    assert report["data"]["distance"] == 2.5
    robot.expect_state(NODE, lambda s: is_enabled(s, "feedback"))
    step(robot, 3)
    ended = robot.expect("result", id=goal)
    assert (ended["status"], ended["data"]["reached"]) == (SUCCEEDED, 3)
    assert robot.expect("result", id=accepted(robot))["status"] == SUCCEEDED


def told(robot: Peer, detail: str) -> None:
    """Wait until a refused goal is told on ``~events``, with this reason."""

    def fits(data: dict[str, str]) -> bool:
        document = json.loads(data["data"])
        return document["outcome"] == "refused" and detail in document["detail"]

    robot.expect("message", where=fits, name=f"{NODE}/events")


def test_what_is_not_taken_is_rejected(graph: Graph, robot: Peer) -> None:
    """ROS 2 has no text for rejected goals, so the events have it."""
    robot.subscribe(f"{NODE}/events", "std_msgs/msg/String")
    assert not robot.expect("answer", id=send(robot, -1.0))["accepted"]
    told(robot, "mission is taken where Missions.free and value.x[0] > 0")
    goal = accepted(robot)
    other = graph.peer()
    assert not other.expect("answer", id=send(other))["accepted"]
    told(robot, "mission is busy: it serves one call at a time")
    robot.expect_state(NODE, lambda s: s["counters"]["refused"] == 2)
    step(robot, 3)
    assert robot.expect("result", id=goal)["status"] == SUCCEEDED


def slow(graph: Graph, built: Built, when: str) -> Peer:
    """A robot whose controller is slow with its first goal; see slow_engine_node.py."""
    script, quality = HERE / "slow_engine_node.py", "qos.step.reliability:='reliable'"
    words = (script, NODE, when, "--ros-args", "-p", quality)
    graph.fork(*words, **built.environment(NODE))
    robot = graph.peer()
    robot.watch(NODE)
    return robot


def test_a_goal_whose_client_was_refused_is_not_carried_out(graph: Graph, built: Built) -> None:
    """The engine comes to it when rclpy could wait no longer."""
    robot = slow(graph, built, "before")
    robot.subscribe(f"{NODE}/events", "std_msgs/msg/String")
    assert not robot.expect("answer", id=send(robot))["accepted"]
    told(robot, "its client was refused already")
    state = robot.expect_state(NODE, lambda s: s["counters"].get("refused") == 1)
    assert state["components"]["Missions"] == "free"
    goal = accepted(robot)
    step(robot, 3)
    assert robot.expect("result", id=goal)["status"] == SUCCEEDED


def test_a_goal_on_which_the_engine_decides_is_waited_for(graph: Graph, built: Built) -> None:
    robot = slow(graph, built, "meanwhile")
    goal = accepted(robot)
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
    step(robot, 2)
    robot.expect_state(NODE, lambda s: s["variables"]["Legs.steps"] == 2)
    robot.publish("/fault", "std_msgs/msg/Bool", {"data": True})
    ended = robot.expect("result", id=goal)
    assert (ended["status"], ended["data"]["reached"]) == (ABORTED, 2)
    assert "Missions is in running" in ended["data"]["message"]


def test_whoever_is_killed_leaves_the_action_to_others(graph: Graph, robot: Peer) -> None:
    caller = graph.peer()
    accepted(caller)
    caller.process.popen.kill()
    caller.process.popen.wait()
    step(robot, 3)
    robot.expect_state(NODE, is_over)
    assert robot.expect("result", id=accepted(robot))["status"] == SUCCEEDED


def test_whoever_is_killed_while_its_goal_is_ending(graph: Graph, robot: Peer) -> None:
    caller = graph.peer()
    goal = accepted(caller)
    caller.begin("cancel_goal", id=goal)
    caller.process.popen.kill()
    caller.process.popen.wait()
    step(robot, 3)
    robot.expect_state(NODE, is_over)
    assert robot.expect("result", id=accepted(robot))["status"] == SUCCEEDED


def test_the_end_of_the_node_aborts_the_goal(graph: Graph, controller: Start) -> None:
    node = controller(NODE, qos__step__reliability="reliable")
    robot = graph.peer()
    robot.watch(NODE)
    goal = accepted(robot)
    node.signal(signal.SIGINT)
    ended = robot.expect("result", id=goal)
    assert ended["status"] == ABORTED and "the node ends" in ended["data"]["message"]
    assert node.wait() == 0


def test_a_cancel_at_once(robot: Peer) -> None:
    for _ in range(20):
        goal = accepted(robot)
        robot.begin("cancel_goal", id=goal)
        assert robot.expect("result", id=goal)["status"] == CANCELED
    robot.expect_state(NODE, lambda s: s["communications"]["mission"] == "idle")


def test_a_managed_node_takes_goals_only_while_it_is_active(
    graph: Graph, controller: Start
) -> None:
    managed = "missions_managed_controller"
    controller(managed, qos__step__reliability="reliable", qos__fault__reliability="reliable")
    robot = graph.peer()
    assert change(robot, managed, CONFIGURE)
    robot.watch(managed)
    assert not robot.expect("answer", id=send(robot))["accepted"]
    assert change(robot, managed, ACTIVATE)
    goal = accepted(robot)
    robot.expect_state(managed, lambda s: s["communications"]["mission"] == "busy")
    assert change(robot, managed, DEACTIVATE)
    ended = robot.expect("result", id=goal)
    assert ended["status"] == ABORTED and "not active" in ended["data"]["message"]
    assert not robot.expect("answer", id=send(robot))["accepted"]
    assert change(robot, managed, ACTIVATE)
    step(robot, 3)  # so that the goal that nobody waits for ends
    robot.expect_state(managed, lambda s: s["communications"]["mission"] == "idle")
    assert robot.expect("result", id=accepted(robot))["status"] == SUCCEEDED
