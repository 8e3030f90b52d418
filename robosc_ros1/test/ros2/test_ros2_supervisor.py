"""A generated supervisor on real rclpy, between a robot and a controller that the test plays."""

from __future__ import annotations

import json
from collections.abc import Callable
from typing import Any

import pytest
from ros2.launching import given_to, started
from ros2.ros2_support import Graph, Peer, Process
from ros_support import await_condition

Start = Callable[..., Process]
NODE = "guarded_arm_supervisor"
READING = "robosc_testing/msg/Reading"
SWITCH = "std_srvs/srv/SetBool"
MOVE = "robosc_testing/action/Move"
NEAR = {"valid": True, "distance": 0.5, "vector": [1.5, 0.0, 0.0]}


@pytest.fixture
def robot(graph: Graph) -> Peer:
    peer = graph.peer("robot")
    peer.watch(NODE)
    peer.subscribe("beacon", "std_msgs/msg/Empty")
    peer.subscribe("speed", "std_msgs/msg/Float32")
    peer.serve("door/lock", SWITCH)
    peer.act("reach", MOVE)
    return peer


@pytest.fixture
def other(graph: Graph) -> Peer:
    """The controller that somebody else wrote, its names remapped."""
    peer = graph.peer("other")
    peer.subscribe("supervised/person", READING)
    peer.subscribe(f"{NODE}/blocked", "std_msgs/msg/String")
    return peer


def repeat(peer: Peer, name: str, type: str, data: dict[str, Any]) -> None:
    """Publish again and again: nobody waits until the supervisor's own subscribers are there."""
    peer.order("repeat", name=name, type=type, data=data, qos={})


def blocked(other: Peer) -> dict[str, Any]:
    document: dict[str, Any] = json.loads(
        other.expect("message", name=f"{NODE}/blocked")["data"]["data"]
    )
    return document


def reasons(document: dict[str, Any]) -> list[str]:
    return [reason["text"] for reason in document["blocked_by"]]


def allow_reaching(robot: Peer, other: Peer) -> None:
    """Have the operator want it, and the door locked."""
    robot.publish("go", "std_msgs/msg/Bool", {"data": True})
    robot.expect_state(NODE, lambda s: s["variables"]["Operator.wanted"])
    call = {"name": "supervised/door/lock", "type": SWITCH, "data": {"data": True}}
    other.order("start_call", **call)
    request = robot.expect("request", name="door/lock")
    robot.order("tell_server", id=request["id"], data={"success": True, "message": "m"})
    assert other.expect("response")["data"] == {"success": True, "message": "m"}
    robot.expect_state(NODE, lambda s: s["components"]["Door"] == "locked")


def goal(robot: Peer, other: Peer, target: float = 7.0) -> dict[str, Any]:
    other.order("send_goal", name="supervised/reach", type=MOVE, data={"target": target})
    assert other.expect("answer", name="supervised/reach")["accepted"]
    return robot.expect("goal", name="reach")


def test_its_clock_cannot_be_changed_while_it_runs(robot: Peer, controller: Start) -> None:
    controller(NODE)
    robot.expect_state(NODE, lambda s: True)
    (refusal,) = robot.order("set_parameter", node=NODE, name="use_sim_time", value=True)
    assert "read-only" in refusal


def test_inputs_go_through_to_the_controller(robot: Peer, other: Peer, controller: Start) -> None:
    controller(NODE)
    repeat(robot, "person", READING, NEAR)
    data = other.expect("message", name="supervised/person")["data"]
    assert (data["distance"], data["vector"]) == (0.5, [1.5, 0.0, 0.0])
    robot.expect_state(NODE, lambda s: s["variables"]["Person.where"] == "near")


def test_what_is_allowed_passes_with_its_own_data(
    robot: Peer, other: Peer, controller: Start
) -> None:
    controller(NODE)
    repeat(other, "supervised/speed", "std_msgs/msg/Float32", {"data": 12.5})
    assert robot.expect("message", name="speed")["data"] == {"data": 12.5}


@pytest.mark.once
def test_what_is_forbidden_is_blocked_and_reported(
    robot: Peer, other: Peer, controller: Start
) -> None:
    controller(NODE)
    repeat(other, "supervised/beacon", "std_msgs/msg/Empty", {})
    told = blocked(other)
    assert told["event"] == {"kind": "request", "name": "warn", "value": None}
    assert reasons(told) == ["requirement warn needs Person.where = near"]
    assert robot.events("message", name="beacon") == []
    robot.publish("person", READING, NEAR)
    robot.expect("message", name="beacon")


def test_numbers_that_are_not_finite_are_blocked(
    robot: Peer, other: Peer, controller: Start
) -> None:
    controller(NODE)
    repeat(other, "supervised/speed", "std_msgs/msg/Float32", {"data": float("nan")})
    assert reasons(blocked(other)) == ["data is nan"]
    assert robot.events("message", name="speed") == []


def test_a_call_that_is_blocked_is_answered_with_defaults(
    robot: Peer, other: Peer, controller: Start
) -> None:
    node = controller(NODE)
    reply = other.order("call", name="supervised/door/lock", type=SWITCH, data={"data": True})
    assert reply == {"success": False, "message": ""}
    told = "request of lock was blocked: requirement lock needs Operator.wanted"
    await_condition(lambda: told in node.output, "the log")
    assert robot.events("request") == []


def test_calls_and_goals_at_once_are_all_answered(
    robot: Peer, other: Peer, controller: Start
) -> None:
    """More than ROS 2 keeps for a server by default."""
    controller(NODE)
    many = {"data": {"data": True}, "count": 200, "at_once": 50}
    answers = other.order("flood", name="supervised/door/lock", type=SWITCH, **many)
    assert answers == [{"success": False, "message": ""}] * 200
    many["data"] = {"target": 7.0}
    ends = other.order("flood_goals", name="supervised/reach", type=MOVE, **many)
    assert ends == [None] * 200  # rejected


def test_a_goal_passes_with_its_id_and_what_comes_of_it(
    robot: Peer, other: Peer, controller: Start
) -> None:
    controller(NODE)
    allow_reaching(robot, other)
    sent = goal(robot, other)
    assert sent["data"] == {"target": 7.0}
    assert sent["uuid"] == other.order("goal_ids")[-1]
    robot.order("tell_server", id=sent["id"], feedback={"progress": 0.5})
    assert other.expect("feedback", name="supervised/reach")["data"] == {"progress": 0.5}
    robot.expect_state(NODE, lambda s: s["variables"]["Arm.progress"] == 0.5)
    robot.order("tell_server", id=sent["id"], end="succeed", result={"code": 0, "reached": 6.5})
    result = other.expect("result", name="supervised/reach")
    assert (result["status"], result["data"]) == (4, {"code": 0, "reached": 6.5})
    robot.expect_state(NODE, lambda s: s["components"]["Arm"] == "resting")


def test_an_abort_of_the_robot_is_one_for_the_controller(
    robot: Peer, other: Peer, controller: Start
) -> None:
    controller(NODE)
    allow_reaching(robot, other)
    sent = goal(robot, other)
    robot.order("tell_server", id=sent["id"], end="abort", result={"code": 9})
    result = other.expect("result", name="supervised/reach")
    assert (result["status"], result["data"]["code"]) == (6, 9)
    robot.expect_state(NODE, lambda s: s["counters"]["errors"] == 1)


@pytest.mark.once
def test_a_goal_that_is_blocked_is_rejected(robot: Peer, other: Peer, controller: Start) -> None:
    node = controller(NODE)
    other.order("send_goal", name="supervised/reach", type=MOVE, data={"target": 1.0})
    assert not other.expect("answer", name="supervised/reach")["accepted"]
    told = "request of reach was blocked: requirement reach needs Door.locked"
    await_condition(lambda: told in node.output, "the log")
    assert robot.events("goal") == []


@pytest.mark.once
def test_a_cancel_of_the_controller_reaches_the_robot(
    robot: Peer, other: Peer, controller: Start
) -> None:
    controller(NODE)
    allow_reaching(robot, other)
    sent = goal(robot, other)
    other.order("cancel_goal", id="1")
    robot.expect("cancel", name="reach")
    robot.order("tell_server", id=sent["id"], end="canceled")
    assert other.expect("result", name="supervised/reach")["status"] == 5
    robot.expect_state(NODE, lambda s: s["components"]["Arm"] == "resting")


@pytest.mark.once
def test_a_message_in_effect_is_stopped_when_it_becomes_forbidden(
    robot: Peer, other: Peer, controller: Start
) -> None:
    controller(NODE, stop_command="speed")
    repeat(other, "supervised/beacon", "std_msgs/msg/Empty", {})
    robot.publish("person", READING, NEAR)
    robot.expect("message", name="beacon")
    assert robot.events("message", name="speed") == []
    robot.publish("person", READING, {"valid": False})
    assert robot.expect("message", name="speed")["data"] == {"data": 0.0}


def test_what_becomes_forbidden_is_ended_if_a_stop_command_is_set(
    robot: Peer, other: Peer, controller: Start
) -> None:
    controller(NODE, stop_command="speed")
    allow_reaching(robot, other)
    sent = goal(robot, other)
    robot.publish("person", READING, NEAR)
    robot.expect("cancel", name="reach")
    robot.order("tell_server", id=sent["id"], end="canceled")
    # The controller did not ask for it: to it, the goal was aborted.
    assert other.expect("result", name="supervised/reach")["status"] == 6


def test_a_goal_whose_server_is_absent_comes_to_nothing(
    graph: Graph, robot: Peer, other: Peer, controller: Start
) -> None:
    robot.order("withdraw", name="reach")
    controller(NODE, timeout__reach=0.5)
    allow_reaching(robot, other)
    other.order("send_goal", name="supervised/reach", type=MOVE, data={})
    assert other.expect("result", name="supervised/reach")["status"] == 6
    robot.expect_state(NODE, lambda s: s["components"]["Arm"] == "resting")


@pytest.mark.once
def test_the_launch_file_starts_both_with_the_right_names(
    graph: Graph, built: Any, robot: Peer
) -> None:
    install = built.folder / "install"
    file = install / NODE / "share" / NODE / "launch" / f"{NODE}.launch.py"
    nodes = started(
        file,
        lambda package: str(install / package / "share" / package),
        stop_command="speed",
        controller_package="guarded_arm",
        controller_executable="guarded_arm",
    )
    assert [(n.package, n.name) for n in nodes] == [(NODE, NODE), ("guarded_arm", "controller")]
    for node in nodes:
        command = node.command(install, graph.folder)
        graph.start(*command, **built.environment(node.package))
    # The controller tells its speed, hears the operator, locks the door, and reaches.
    robot.expect("message", name="speed")
    repeat(robot, "go", "std_msgs/msg/Bool", {"data": True})
    request = robot.expect("request", name="door/lock")
    robot.order("tell_server", id=request["id"], data={"success": True})
    sent = robot.expect("goal", name="reach")
    assert sent["data"] == {"target": 2.0}
    robot.order("tell_server", id=sent["id"], end="succeed", result={"code": 0})
    robot.expect_state(NODE, lambda s: s["variables"]["Arm.last"] == "good")
    # All of that went through the supervisor: nobody else sends to the robot.
    assert robot.order("senders", name="speed") == [NODE]


def test_the_launch_file_starts_the_supervisor_alone(built: Any) -> None:
    file = built.folder / "src" / NODE / "launch" / f"{NODE}.launch.py"
    (node,) = started(file, lambda package: f"/share/{package}", ns="left", near_by="0.5")
    assert (node.package, node.namespace) == (NODE, "left")
    assert node.parameters[0] == f"/share/{NODE}/config/{NODE}.yaml"
    assert given_to(node, f"/left/{NODE}") == {"near_by": 0.5}
    file = built.folder / "src" / NODE / "launch" / f"{NODE}.launch.py"
    words = {"controller_package": "p", "controller_args": "-x 'a b'", "controller_name": ""}
    _, other = started(file, str, **words, ns="left", use_sim_time="true")
    assert (other.name, other.namespace, other.arguments) == (None, "left", ["-x", "a b"])
    assert ("reach/_action/get_result", "supervised/reach/_action/get_result") in other.remappings
    assert other.parameters == [{"use_sim_time": True}]


@pytest.mark.parametrize("package", [NODE, "orders_supervisor", "missions_supervisor"])
def test_the_package_s_own_test_plays_robot_and_controller(
    built: Any, graph: Graph, package: str
) -> None:
    test = graph.start(
        graph.bed.python, "-m", "pytest", "-q", "-s", "-p", "no:cacheprovider",
        built.folder / "src" / package / "test",
        **built.environment(package),
    )  # fmt: skip
    code = test.wait(240.0)
    assert code == 0, test.output
    assert " passed" in test.output
