"""The example "order" on ROS 1: a client of actionlib orders, a base of actionlib drives."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

import pytest
from actionlib_msgs.msg import GoalStatus
from ros1.stage import Node, Puppet, Stage
from ros_support import Master, Workspace

ORDER = {"name": "/order", "type": "robot_common/OrderAction"}
DRIVE = {"name": "/drive", "type": "robot_common/NavigateAction"}
WAY = {"x": [1.0, 3.0], "y": [2.0, 4.0]}


@pytest.fixture
def stage(example_workspace: Workspace, shared_master: Master) -> Stage:
    return Stage(example_workspace, shared_master)


@pytest.fixture
def base(stage: Stage) -> Iterator[Puppet]:
    """What drives, until a test ends it."""
    with stage.puppet() as puppet:
        puppet.do("action", **DRIVE, mode="hold")
        yield puppet


@pytest.fixture
def node(stage: Stage, ear: Puppet, base: Puppet) -> Iterator[Node]:
    with stage.controller(ear, "order_controller", stop__silence=3600.0) as running:
        yield running


def press(puppet: Puppet, pressed: bool) -> None:
    puppet.publish("/emergency_stop", "std_msgs/Bool", pressed)


def send(puppet: Puppet, **way: Any) -> int:
    mark = puppet.mark
    puppet.do("send", **ORDER, fields=WAY | way)
    return mark


def end(puppet: Puppet, since: int) -> dict[str, Any]:
    return puppet.wait(lambda line: line.get("ended") == "/order", "its end", since=since)


def drives(base: Puppet, since: int, x: float) -> int:
    """Wait until a drive has begun, and return the place of what comes then."""
    asked = base.wait(lambda line: line.get("asked") == "/drive", "a drive", since=since)
    assert asked["message"]["x"] == x
    return base.lines.index(asked) + 1


@pytest.mark.once
def test_an_order_is_carried_out(puppet: Puppet, base: Puppet, node: Node) -> None:
    """It is refused as long as nothing is known of the emergency stop, and paused by it."""
    refused = end(puppet, send(puppet))
    assert refused["status"] == GoalStatus.REJECTED and "stop.fresh" in refused["text"]
    press(puppet, False)
    node.shows(lambda s: s["communications"]["stop"] == "fresh")
    assert end(puppet, send(puppet, y=[2.0]))["status"] == GoalStatus.REJECTED
    mark = send(puppet)
    place = drives(base, 0, 1.0)
    base.do("progress", name="/drive", fields={"distance": 0.5})
    told = puppet.wait(
        lambda line: line.get("progress") == "/order" and line["message"]["distance"] == 0.5,
        "feedback", since=mark,
    )  # fmt: skip
    assert told["message"]["reached"] == 0
    base.do("finish", name="/drive", mode="succeed")
    place = drives(base, place, 3.0)
    press(puppet, True)
    base.wait(lambda line: line.get("cancelled") == "/drive", "the cancel", since=place)
    node.shows(lambda s: s["communications"]["drive"] == "idle", since=node.ear.mark)
    press(puppet, False)
    drives(base, place, 3.0)
    base.do("finish", name="/drive", mode="succeed")
    ended = end(puppet, mark)
    assert ended["status"] == GoalStatus.SUCCEEDED
    assert ended["result"] == {"reached": 2, "message": "done"}


def test_a_cancelled_order_has_ended_when_the_robot_stands(
    puppet: Puppet, base: Puppet, node: Node
) -> None:
    press(puppet, False)
    node.shows(lambda s: s["communications"]["stop"] == "fresh")
    base.do("action", **DRIVE, mode="go on")  # its cancel takes time
    mark = send(puppet)
    place = drives(base, 0, 1.0)
    puppet.do("cancel")
    base.wait(lambda line: line.get("cancelled") == "/drive", "the cancel", since=place)
    both = {"order": "ending", "drive": "cancelling"}
    node.shows(lambda s: both.items() <= s["communications"].items())
    assert not [line for line in puppet.lines[mark:] if line.get("ended")]
    base.do("finish", name="/drive", mode="preempt")
    ended = end(puppet, mark)
    assert ended["status"] == GoalStatus.PREEMPTED
    assert "Way is in stopping" in ended["text"]
