"""A shadow of a controller that drives, on real rclpy: a mode of the monitor."""

from __future__ import annotations

import json
from collections.abc import Callable
from typing import Any

import pytest
from ros2.ros2_support import Graph, Peer, Process
from ros_support import await_condition

Start = Callable[..., Process]
READING = "robosc_testing/msg/Reading"
NEAR = {"valid": True, "distance": 0.5, "vector": [1.5, 0.0, 0.0]}
NODE, SHADOW = "guarded_arm", "guarded_arm_monitor"


@pytest.fixture
def robot(graph: Graph) -> Peer:
    peer = graph.peer("robot")
    peer.watch(SHADOW)
    peer.subscribe(f"{SHADOW}/events", "std_msgs/msg/String")
    peer.subscribe("beacon", "std_msgs/msg/Empty")
    peer.serve("door/lock", "std_srvs/srv/SetBool", {"success": True})
    peer.act("reach", "robosc_testing/action/Move")
    return peer


def told(robot: Peer, name: str, **more: Any) -> list[Any]:
    heard = robot.events("message", name=f"{SHADOW}/events")
    documents = [json.loads(one["data"]["data"]) for one in heard]
    return [
        e for e in documents
        if e["event"]["name"] == name and all(e.get(k) == v for k, v in more.items())
    ]  # fmt: skip


@pytest.mark.once
def test_a_shadow_tells_what_the_controller_sends_and_sends_nothing(
    robot: Peer, controller: Start
) -> None:
    controller(SHADOW, shadow=True)
    robot.order("repeat", name="person", type=READING, data=NEAR, qos={})
    await_condition(lambda: told(robot, "warn", outcome="withheld"), "what would be sent")
    robot.expect_state(SHADOW, lambda s: s["counters"]["withheld"] > 5)
    assert robot.events("message", name="beacon") == []
    controller(NODE)
    robot.expect("message", name="beacon")
    await_condition(lambda: told(robot, "warn", seen=True, outcome="applied"), "what was sent")
    assert robot.order("senders", name="beacon") == [NODE]
    state = robot.expect_state(SHADOW, lambda s: s["counters"]["commands"] > 3)
    assert state["counters"]["forbidden"] == state["counters"]["mismatches"] == 0


def test_what_is_preferred_holds_back_as_in_the_controller(graph: Graph, controller: Start) -> None:
    """Though a shadow publishes nothing, it knows of the data whether they could be sent."""
    controller("trolley_monitor", shadow=True)
    robot = graph.peer()
    robot.watch("trolley_monitor")
    robot.order("say", name="/near", type="std_msgs/msg/Float32", data={"data": 2.0})
    robot.expect_state("trolley_monitor", lambda s: s["communications"]["near"] == "fresh")

    def names(state: Any) -> set[str]:
        return {e["event"]["name"] for e in state["latest"] if e["outcome"] == "withheld"}

    robot.expect_state("trolley_monitor", lambda s: s["counters"]["withheld"] > 30)
    state = robot.expect_state("trolley_monitor", lambda s: names(s) == {"move"})
    more = state["counters"]["withheld"] + 20
    assert names(
        robot.expect_state("trolley_monitor", lambda s: s["counters"]["withheld"] > more)
    ) == {"move"}
