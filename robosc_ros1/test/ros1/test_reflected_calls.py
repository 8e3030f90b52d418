"""Served calls and goals with data of every primitive type, on a roscore: they come back as they were."""

from __future__ import annotations

from typing import Any

import pytest
from actionlib_msgs.msg import GoalStatus
from primitives import PRIMITIVES_OF_ROS1
from reflecting import call
from ros1.stage import Node, Puppet

HEADER = {"header": {"seq": 5, "stamp": {"secs": 3, "nsecs": 7}, "frame_id": "größer"}}
SERVICE = {"name": "/reflect", "type": "robosc_testing/Reflect"}
ACTION = {"name": "/shine", "type": "robosc_testing/ShineAction"}
GOALS = 20

pytestmark = pytest.mark.parametrize("model", ["reflector"])


@pytest.fixture
def caller(nodes: tuple[Node, ...], puppet: Puppet) -> Puppet:
    return puppet


def data(succeeds: bool = True) -> dict[str, Any]:
    return call(PRIMITIVES_OF_ROS1, succeeds) | HEADER


def test_a_call(caller: Puppet) -> None:
    caller.do("call", **SERVICE, fields=data())
    answer = caller.wait(lambda line: line.get("answered") == "/reflect", "the answer")
    assert answer["message"] == data()


@pytest.mark.parametrize("succeeds", [True, False])
def test_a_goal(caller: Puppet, succeeds: bool) -> None:
    """The controller gives feedback and the result at once, in an order that a supervisor demands."""
    for _ in range(GOALS):
        mark = caller.mark
        caller.do("send", **ACTION, fields=data(succeeds))
        end = caller.wait(lambda line: line.get("ended") == "/shine", "the end", since=mark)
        assert end["status"] == (GoalStatus.SUCCEEDED if succeeds else GoalStatus.ABORTED), end
        assert end["result"] == data(succeeds)
    # The test's own client may get the result first, and then ignores the feedback.
    reports = [line["message"] for line in caller.lines if line.get("progress") == "/shine"]
    assert all(report == data() for report in reports)
    assert bool(reports) is succeeds
