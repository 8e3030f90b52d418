"""The example "order" on real rclpy: a client orders, a base drives."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import pytest
from ros2.ros2_support import Graph, Peer, Process

NODE = "order_controller"
ORDER = {"name": "/order", "type": "robot_common/action/Order"}
WAY = {"x": [1.0, 3.0], "y": [2.0, 4.0]}
SUCCEEDED, CANCELED = 4, 5


@pytest.fixture
def base(graph: Graph) -> Peer:
    """What drives, until a test ends it."""
    peer = graph.peer("base")
    peer.act("/drive", "robot_common/action/Navigate")
    return peer


@pytest.fixture
def client(graph: Graph, base: Peer, controller: Callable[..., Process]) -> Peer:
    # What it said last of the stop counts however long the test takes.
    controller(NODE, qos__stop__reliability="reliable", Stop__silence=600.0)
    peer = graph.peer()
    peer.watch(NODE)
    return peer


def press(client: Peer, pressed: bool) -> None:
    client.publish("/emergency_stop", "std_msgs/msg/Bool", {"data": pressed})


def send(client: Peer, **way: Any) -> str:
    goal: str = client.order("send_goal", **ORDER, data=WAY | way)
    return goal


def is_accepted(client: Peer, goal: str) -> bool:
    return bool(client.expect("answer", id=goal)["accepted"])


def drives(base: Peer, x: float) -> str:
    drive: str = base.expect("goal", where=lambda data: data["x"] == x)["id"]
    return drive


@pytest.mark.once
def test_an_order_is_carried_out(client: Peer, base: Peer) -> None:
    """It is refused as long as nothing is known of the emergency stop, and paused by it."""
    assert not is_accepted(client, send(client))
    press(client, False)
    client.expect_state(NODE, lambda s: s["communications"]["stop"] == "fresh")
    assert not is_accepted(client, send(client, y=[2.0]))
    goal = send(client)
    assert is_accepted(client, goal)
    first = drives(base, 1.0)
    base.order("tell_server", id=first, feedback={"distance": 0.5})
    told = client.expect("feedback", id=goal, where=lambda data: data["distance"] == 0.5)
    assert told["data"]["reached"] == 0
    base.order("tell_server", id=first, end="succeed")
    second = drives(base, 3.0)
    press(client, True)
    base.expect("cancel", id=second)
    base.order("tell_server", id=second, end="canceled")
    client.expect_state(NODE, lambda s: s["communications"]["drive"] == "idle")
    press(client, False)
    base.order("tell_server", id=drives(base, 3.0), end="succeed")
    ended = client.expect("result", id=goal)
    assert (ended["status"], ended["data"]) == (SUCCEEDED, {"reached": 2, "message": "done"})


def test_a_cancelled_order_has_ended_when_the_robot_stands(client: Peer, base: Peer) -> None:
    press(client, False)
    client.expect_state(NODE, lambda s: s["communications"]["stop"] == "fresh")
    goal = send(client)
    assert is_accepted(client, goal)
    drive = drives(base, 1.0)
    client.order("cancel_goal", id=goal)
    base.expect("cancel", id=drive)
    both = {"order": "ending", "drive": "cancelling"}
    client.expect_state(NODE, lambda s: both.items() <= s["communications"].items())
    assert not client.events("result", id=goal)
    base.order("tell_server", id=drive, end="canceled")
    ended = client.expect("result", id=goal)
    assert ended["status"] == CANCELED
    assert "Way is in stopping" in ended["data"]["message"]
