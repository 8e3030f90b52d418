"""Served calls and goals with data of every primitive type, on rclpy: they come back as they were."""

from __future__ import annotations

from typing import Any

import pytest
from primitives import PRIMITIVES_OF_ROS2
from reflecting import call
from ros2.ros2_support import Peer

HEADER = {"header": {"stamp": {"sec": 3, "nanosec": 7}, "frame_id": "größer"}}
SERVICE = {"name": "/reflect", "type": "robosc_testing/srv/Reflect"}
ACTION = {"name": "/shine", "type": "robosc_testing/action/Shine"}
SUCCEEDED, ABORTED = 4, 6
GOALS = 20

pytestmark = pytest.mark.parametrize("model", ["reflector"])


def data(succeeds: bool = True) -> dict[str, Any]:
    return call(PRIMITIVES_OF_ROS2, succeeds) | HEADER


def test_a_call(watcher: Peer) -> None:
    assert watcher.order("call", **SERVICE, data=data()) == data()


@pytest.mark.parametrize("succeeds", [True, False])
def test_a_goal(watcher: Peer, succeeds: bool) -> None:
    """The controller gives feedback and the result at once, in an order that a supervisor demands."""
    for _ in range(GOALS):
        goal = watcher.order("send_goal", **ACTION, data=data(succeeds))
        if succeeds:
            assert watcher.expect("feedback", id=goal)["data"] == data()
        end = watcher.expect("result", id=goal)
        assert end["status"] == (SUCCEEDED if succeeds else ABORTED), end
        assert end["data"] == data(succeeds)
