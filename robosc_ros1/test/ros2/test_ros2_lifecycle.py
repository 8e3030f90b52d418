"""A managed node on real rclpy: it follows when configured, and commands only while it is active."""

from __future__ import annotations

import json
from collections.abc import Callable
from pathlib import Path

import pytest
from ros2.ros2_support import Graph, Peer, Process
from ros_support import await_condition

Start = Callable[..., Process]
NODE = "guarded_arm_managed_controller"
GUARD = "guarded_arm_managed_supervisor"
READING = "robosc_testing/msg/Reading"
NEAR = {"valid": True, "distance": 0.5, "vector": [1.5, 0.0, 0.0]}
CONFIGURE, CLEANUP, ACTIVATE, DEACTIVATE, SHUTDOWN = 1, 2, 3, 4, 6  # lifecycle_msgs/msg/Transition


@pytest.fixture
def robot(graph: Graph) -> Peer:
    peer = graph.peer("robot")
    peer.subscribe("beacon", "std_msgs/msg/Empty")
    peer.subscribe("speed", "std_msgs/msg/Float32")
    return peer


def change(peer: Peer, node: str, transition: int) -> bool:
    """Ask for a transition; whether it succeeded."""
    name, type_ = f"{node}/change_state", "lifecycle_msgs/srv/ChangeState"
    found = peer.order("call", name=name, type=type_, data={"transition": {"id": transition}})
    return bool(found["success"])


def stopped(peer: Peer, node: str, value: str | None) -> None:
    peer.expect_state(node, lambda s: s["stopped"] == value)


def all_of(topics: dict[str, list[str]], wanted: set[str]) -> dict[str, list[str]]:
    """The topics, if the wanted ones are among them."""
    return topics if wanted <= topics.keys() else {}


def test_it_starts_with_empty_lists_in_a_file_of_parameters(
    robot: Peer, controller: Start, tmp_path: Path
) -> None:
    file = tmp_path / "given.yaml"
    file.write_text("/**:\n  ros__parameters: {footprint: []}\n", encoding="utf-8")
    controller(NODE, arguments=("--params-file", str(file)))
    assert change(robot, NODE, CONFIGURE)


def test_it_commands_only_while_it_is_active(robot: Peer, controller: Start) -> None:
    node = controller(NODE)
    assert change(robot, NODE, CONFIGURE)
    robot.watch(NODE)
    stopped(robot, NODE, "not active")
    robot.publish("person", READING, NEAR)
    robot.expect_state(NODE, lambda s: s["variables"]["Person.where"] == "near")
    assert robot.events("message", name="beacon") == []
    assert change(robot, NODE, ACTIVATE)
    robot.expect("message", name="beacon")
    stopped(robot, NODE, None)
    assert change(robot, NODE, DEACTIVATE)
    stopped(robot, NODE, "not active")
    robot.publish("go", "std_msgs/msg/Bool", {"data": True})
    robot.expect_state(NODE, lambda s: s["stopped"] and s["variables"]["Operator.wanted"])
    assert change(robot, NODE, ACTIVATE)
    stopped(robot, NODE, None)
    assert change(robot, NODE, DEACTIVATE)
    assert change(robot, NODE, SHUTDOWN)
    assert node.wait() == 0


def test_it_begins_anew_after_a_cleanup(robot: Peer, controller: Start) -> None:
    controller(NODE)
    assert change(robot, NODE, CONFIGURE)
    robot.watch(NODE)
    robot.publish("person", READING, NEAR)
    robot.expect_state(NODE, lambda s: s["variables"]["Person.where"] == "near")
    own = {f"/{NODE}/{name}" for name in ("state", "events", "model")}
    wanted = own | {"/person", "/go", "/charge", "/beacon", "/speed"}
    before = await_condition(lambda: all_of(robot.order("topics"), wanted), "all topics")
    assert change(robot, NODE, CLEANUP)
    assert change(robot, NODE, CONFIGURE)
    robot.expect_state(NODE, lambda s: s["number"] == 0)
    await_condition(lambda: robot.order("topics") == before, "the same topics")
    robot.publish("person", READING, NEAR)
    robot.expect_state(NODE, lambda s: s["variables"]["Person.where"] == "near")
    assert change(robot, NODE, ACTIVATE)
    robot.expect("message", name="beacon")


def test_no_second_goal_joins_one_that_outlives_a_cleanup(robot: Peer, controller: Start) -> None:
    robot.serve("door/lock", "std_srvs/srv/SetBool", {"success": True})
    robot.act("reach", "robosc_testing/action/Move", cancel=False)
    controller(NODE)
    assert change(robot, NODE, CONFIGURE)
    robot.watch(NODE)
    assert change(robot, NODE, ACTIVATE)
    robot.publish("go", "std_msgs/msg/Bool", {"data": True})
    goal = robot.expect("goal", name="reach")
    for transition in (DEACTIVATE, CLEANUP, CONFIGURE, ACTIVATE):
        assert change(robot, NODE, transition)
    robot.expect("cancel", name="reach")
    robot.expect_state(NODE, lambda s: any("that was cancelled" in f for f in s["faults"]))
    robot.publish("go", "std_msgs/msg/Bool", {"data": True})
    robot.expect_state(NODE, lambda s: s["communications"]["reach"] == "busy")
    assert robot.events("goal", name="reach") == []
    robot.order("tell_server", id=goal["id"], end="succeed", result={"code": 0})
    own = robot.expect("goal", name="reach")
    robot.order("send_goal", name="reach", type="robosc_testing/action/Move", data={"target": 1.0})
    other = robot.expect("goal", name="reach")
    shown = robot.expect_state(NODE, lambda s: other["uuid"] in str(s["faults"]))
    assert str(shown["faults"]).count(other["uuid"]) == 1
    assert own["uuid"] not in str(shown["faults"])


@pytest.mark.parametrize("package", [NODE, GUARD])
def test_a_change_that_is_not_possible_now_is_refused(
    robot: Peer, controller: Start, package: str
) -> None:
    node = controller(package)
    assert not change(robot, package, ACTIVATE)
    assert change(robot, package, CONFIGURE)
    assert not change(robot, package, CONFIGURE)
    assert not change(robot, package, 99)
    assert change(robot, package, ACTIVATE)
    assert "Traceback" not in node.output


def test_wrong_parameters_keep_it_unconfigured(robot: Peer, controller: Start) -> None:
    node = controller(NODE, rate=-1.0)
    assert not change(robot, NODE, CONFIGURE)
    assert "parameter rate must be a number of at least 0.001" in node.output
    node.signal(2)
    assert node.wait() == 0


def test_a_supervisor_blocks_everything_while_it_is_not_active(
    robot: Peer, graph: Graph, controller: Start
) -> None:
    controller(GUARD)
    other = graph.peer("other")
    assert change(robot, GUARD, CONFIGURE)
    other.subscribe(f"{GUARD}/blocked", "std_msgs/msg/String")
    speed = {"name": "supervised/speed", "type": "std_msgs/msg/Float32", "data": {"data": 12.5}}
    other.order("repeat", **speed, qos={})
    told = json.loads(other.expect("message", name=f"{GUARD}/blocked")["data"]["data"])
    assert [reason["kind"] for reason in told["blocked_by"]] == ["stopped"]
    assert robot.events("message", name="speed") == []
    assert change(robot, GUARD, ACTIVATE)
    assert robot.expect("message", name="speed")["data"] == {"data": 12.5}
