"""A supervisor on a roscore when what stands on either side dies, comes late, or talks nonsense."""

from __future__ import annotations

import signal
from collections.abc import Iterator

import pytest
from ros1.stage import Node, Puppet, Stage
from ros1.test_supervisor import FLOAT, GRAB, LIGHT, NODE, STOP, TWIST, speed, vel

SEND = {"name": "/supervised/grab", **GRAB, "fields": {}}


@pytest.fixture
def robot(guarded: Stage) -> Iterator[Puppet]:
    """The robot without its arm."""
    with guarded.puppet() as running:
        running.do("listen", topic="/vel", type=TWIST)
        yield running


@pytest.fixture
def arm(guarded: Stage) -> Iterator[Puppet]:
    with guarded.puppet() as running:
        running.do("action", name="/grab", **GRAB, mode="hold")
        yield running


@pytest.fixture
def other(guarded: Stage) -> Iterator[Puppet]:
    """The controller."""
    with guarded.puppet() as running:
        yield running


def get_ready(node: Node, robot: Puppet, other: Puppet) -> None:
    """Have the robot stand before something."""
    mark = other.mark
    robot.publish("/distance", FLOAT, 0.1, times=3)
    node.shows(lambda s: s["components"]["DistanceSensor"] == "sensing", since=mark)
    vel(other, STOP)
    node.shows(lambda s: s["components"]["Motor"] == "stopped", since=mark)


def in_state(node: Node, state: str, since: int = 0) -> None:
    node.shows(lambda s: s["components"]["ObstacleGrabber"] == state, since=since)


def test_a_goal_goes_on_when_its_controller_dies(
    guarded: Stage, robot: Puppet, arm: Puppet, other: Puppet
) -> None:
    with guarded.controller(other, NODE) as node, guarded.puppet() as doomed:
        get_ready(node, robot, other)
        doomed.do("send", **SEND)
        in_state(node, "grabbing")
        # Another controller cannot have the arm meanwhile.
        other.do("send", **SEND)
        assert "it is busy" in other.wait(lambda line: line.get("ended"), "the end")["text"]
        doomed.process.kill()
        arm.wait(lambda line: line.get("asked") == "/grab", "the goal")
        mark = other.mark
        arm.do("finish", name="/grab", mode="succeed")
        in_state(node, "looking", mark)
        get_ready(node, robot, other)
        in_state(node, "idle", mark)
        other.do("send", **SEND)
        in_state(node, "grabbing", mark)


@pytest.mark.parametrize("comes_back", [False, True])
def test_a_goal_ends_when_the_robot_s_server_dies(
    guarded: Stage, robot: Puppet, arm: Puppet, other: Puppet, comes_back: bool
) -> None:
    patience = 60.0 if comes_back else 0.5
    with guarded.controller(other, NODE, server_lost_after=patience) as node:
        get_ready(node, robot, other)
        other.do("send", **SEND)
        in_state(node, "grabbing")
        robot.sees_a_goal_run("/grab")
        arm.process.kill()
        mark = other.mark
        if comes_back:
            robot.do("action", name="/grab", **GRAB, mode="hold")
        # Aborted in the robot's stead; or lost, which the client sees for itself.
        assert other.wait(lambda line: line.get("ended"), "the end")["status"] in (4, 9)
        in_state(node, "looking", mark)
        if comes_back:
            get_ready(node, robot, other)
            other.do("send", **SEND)
            robot.wait(lambda line: line.get("asked") == "/grab", "the next goal")


def test_a_latched_message_reaches_a_controller_that_comes_later(guarded: Stage) -> None:
    command = ("rostopic", "pub", "-l", "/distance", FLOAT, "0.5")
    with (
        guarded.puppet() as ear,
        guarded.workspace.start(*command, master=guarded.master),
        guarded.controller(ear, NODE) as node,
    ):
        node.shows(lambda s: s["variables"]["DistanceSensor.current"] == "free")
        with guarded.puppet() as late:
            late.do("listen", topic="/supervised/distance", type=FLOAT)
            late.hears("/supervised/distance", lambda m: m["data"] == 0.5)


GARBAGE = """
import time, rospy
from geometry_msgs.msg import Twist
from rospy.msg import AnyMsg
from std_msgs.msg import Float32
rospy.init_node("garbage")
message = AnyMsg()
message._buff = b"\\\\x01"
publishers = [rospy.Publisher("/supervised/vel", Twist, queue_size=1, latch=True),
              rospy.Publisher("/distance", Float32, queue_size=1, latch=True)]
for publisher in publishers:
    while not publisher.get_num_connections():
        time.sleep(0.01)
    publisher.publish(message)
rospy.spin()
"""


def test_bytes_that_are_no_message_are_survived(
    guarded: Stage, robot: Puppet, other: Puppet
) -> None:
    with guarded.controller(other, NODE, timeout__distance=600.0) as node:
        command = ("/usr/bin/python3", "-c", GARBAGE.replace("\\\\", "\\"))
        with guarded.workspace.start(*command, master=guarded.master):
            robot.publish("/distance", FLOAT, 2.0, times=3)
            node.shows(lambda s: s["variables"]["DistanceSensor.current"] == "free")
            vel(other, speed(0.3))
            robot.hears("/vel", lambda m: m["linear"]["x"] == 0.3)
        assert len(robot.all_heard("/vel")) == 1


def test_a_supervisor_that_is_started_again_guards_the_same_controller(
    guarded: Stage, robot: Puppet, arm: Puppet, other: Puppet
) -> None:
    for _ in range(2):
        mark, seen, told = other.mark, robot.mark, arm.mark
        with guarded.controller(other, NODE) as node:
            get_ready(node, robot, other)
            other.do("send", **SEND)
            in_state(node, "grabbing", mark)
            arm.wait(lambda line: line.get("asked") == "/grab", "the goal", since=told)
            arm.do("finish", name="/grab", mode="succeed")
            in_state(node, "looking", mark)
            robot.hears("/vel", since=seen)


def test_a_call_under_way_fails_when_the_supervisor_ends(
    guarded: Stage, robot: Puppet, other: Puppet
) -> None:
    robot.do("service", name="/set_light_state", **LIGHT, mode="hang")
    with guarded.controller(other, NODE) as node:
        other.do("call", name="/supervised/set_light_state", **LIGHT, fields={"state": True})
        robot.wait(lambda line: line.get("asked") == "/set_light_state", "the call")
        node.process.send_signal(signal.SIGINT)
        assert other.wait(lambda line: line.get("failure"), "the failure")
        assert node.process.wait(60) == 0
