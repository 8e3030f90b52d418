"""A supervisor on rclpy when what stands on either side dies, comes late, or talks nonsense."""

from __future__ import annotations

import signal
from collections.abc import Callable
from typing import Any

import pytest
from ros2.bed import HERE
from ros2.ros2_support import Graph, Peer, Process
from ros2.test_ros2_supervisor import (
    MOVE,
    NEAR,
    NODE,
    READING,
    SWITCH,
    allow_reaching,
    repeat,
)
from ros_support import await_condition

Start = Callable[..., Process]
SHORT_LEASE = {"FASTRTPS_DEFAULT_PROFILES_FILE": str(HERE / "short_lease.xml")}
"""How soon a killed process is noticed, is said by itself when it joins."""


@pytest.fixture
def robot(graph: Graph) -> Peer:
    """The robot without its arm."""
    peer = graph.peer("robot")
    peer.watch(NODE)
    peer.subscribe("speed", "std_msgs/msg/Float32")
    peer.serve("door/lock", SWITCH)
    return peer


@pytest.fixture
def other(graph: Graph) -> Peer:
    """The controller."""
    return graph.peer("other")


def send(peer: Peer, accepted: bool = True) -> None:
    peer.order("send_goal", name="supervised/reach", type=MOVE, data={"target": 7.0})
    assert peer.expect("answer", name="supervised/reach")["accepted"] is accepted


def arm(robot: Peer, state: str) -> dict[str, Any]:
    return robot.expect_state(NODE, lambda s: s["components"]["Arm"] == state)


def test_a_goal_goes_on_when_its_controller_dies(
    graph: Graph, robot: Peer, other: Peer, controller: Start
) -> None:
    robot.act("reach", MOVE)
    controller(NODE)
    allow_reaching(robot, other)
    doomed = graph.peer("doomed", **SHORT_LEASE)
    send(doomed)
    goal = robot.expect("goal", name="reach")
    # Another controller cannot have the arm meanwhile.
    send(other, accepted=False)
    doomed.process.signal(signal.SIGKILL)
    robot.order("tell_server", id=goal["id"], end="succeed", result={"code": 0})
    robot.expect_state(NODE, lambda s: s["variables"]["Arm.last"] == "good")
    send(other)
    robot.expect("goal", name="reach")


def test_a_goal_ends_when_the_robot_s_server_dies(
    graph: Graph, robot: Peer, other: Peer, controller: Start
) -> None:
    controller(NODE, server_lost_after=0.5)
    server = graph.peer("server", **SHORT_LEASE)
    server.act("reach", MOVE)
    allow_reaching(robot, other)
    send(other)
    server.expect("goal", name="reach")
    server.process.signal(signal.SIGKILL)
    assert other.expect("result", name="supervised/reach")["status"] == 6
    arm(robot, "resting")
    robot.act("reach", MOVE)

    def has_come() -> bool:
        """A goal that finds only what the dead server has left is lost, and ends."""
        ends = len(other.events("result", name="supervised/reach"))
        send(other)
        come = lambda: robot.events("goal", name="reach")  # noqa: E731
        ended = lambda: len(other.events("result", name="supervised/reach")) > ends  # noqa: E731
        await_condition(lambda: come() or ended(), "the goal or its end")
        return bool(come())

    await_condition(has_come, "a goal")


def test_a_goal_ends_when_the_robot_s_server_is_started_anew(
    robot: Peer, other: Peer, controller: Start
) -> None:
    robot.act("reach", MOVE)
    controller(NODE, server_lost_after=600.0)
    allow_reaching(robot, other)
    send(other)
    robot.expect("goal", name="reach")
    robot.order("withdraw", name="reach")
    robot.act("reach", MOVE)
    assert other.expect("result", name="supervised/reach")["status"] == 6
    arm(robot, "resting")


def test_a_goal_that_the_robot_rejects_is_aborted(
    robot: Peer, other: Peer, controller: Start
) -> None:
    robot.act("reach", MOVE, accept=False)
    controller(NODE)
    allow_reaching(robot, other)
    send(other)
    assert other.expect("result", name="supervised/reach")["status"] == 6
    robot.expect_state(
        NODE, lambda s: s["counters"]["errors"] == 1 and s["components"]["Arm"] == "resting"
    )


def test_a_lasting_message_reaches_a_controller_that_comes_later(
    graph: Graph, robot: Peer, controller: Start
) -> None:
    lasting = {"durability": "transient_local"}
    robot.publish("go", "std_msgs/msg/Bool", {"data": True}, matched=0, **lasting)
    controller(NODE, qos__go__durability="transient_local")
    robot.expect_state(NODE, lambda s: s["variables"]["Operator.wanted"])
    late = graph.peer("late")
    late.subscribe("supervised/go", "std_msgs/msg/Bool", **lasting)
    assert late.expect("message", name="supervised/go")["data"] == {"data": True}


def test_bytes_that_are_no_message_are_survived(
    robot: Peer, other: Peer, controller: Start
) -> None:
    node = controller(NODE)
    robot.order("publish_bytes", name="person", type=READING, content=[1, 2, 3])
    other.order("publish_bytes", name="supervised/speed", type="std_msgs/msg/Float32", content=[1])
    repeat(robot, "person", READING, NEAR)
    robot.expect_state(NODE, lambda s: s["variables"]["Person.where"] == "near")
    repeat(other, "supervised/speed", "std_msgs/msg/Float32", {"data": 3.0})
    robot.expect("message", name="speed", where=lambda data: data == {"data": 3.0})
    assert node.popen.poll() is None


def test_a_supervisor_that_is_started_again_guards_the_same_controller(
    graph: Graph, robot: Peer, other: Peer, controller: Start
) -> None:
    robot.act("reach", MOVE)
    first = controller(NODE)
    allow_reaching(robot, other)
    send(other)
    goal = robot.expect("goal", name="reach")
    first.end()  # which cancels what it let pass
    robot.expect("cancel", name="reach")
    robot.order("tell_server", id=goal["id"], end="canceled")
    for peer in (robot, other):
        peer.order("see_end", node=NODE)
    controller(NODE)
    arm(robot, "resting")
    allow_reaching(robot, other)
    send(other)
    robot.expect("goal", name="reach")
