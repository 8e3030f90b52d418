"""A supervisor that corrects messages, calls and goals of a controller, on real rclpy."""

from __future__ import annotations

import json
from collections.abc import Callable
from typing import Any

import pytest
from ros2.ros2_support import Graph, Peer, Process
from runtime.schemas import validate

Start = Callable[..., Process]
NODE = "crane_supervisor"
FLOAT = "std_msgs/msg/Float32"
STRING = "std_msgs/msg/String"
SWITCH = "std_srvs/srv/SetBool"
MOVE = "robosc_testing/action/Move"


@pytest.fixture
def robot(graph: Graph) -> Peer:
    peer = graph.peer("robot")
    peer.watch(NODE)
    peer.subscribe("hoist", FLOAT)
    peer.serve("brake", SWITCH)
    peer.act("reach", MOVE)
    return peer


@pytest.fixture
def driver(graph: Graph, robot: Peer, controller: Start) -> Peer:
    peer = graph.peer("driver")
    for topic in ("blocked", "events"):
        peer.subscribe(f"{NODE}/{topic}", STRING)
    controller(NODE, qos__limit__reliability="reliable", qos__hoist__reliability="reliable")
    robot.expect_state(NODE, lambda s: True)
    return peer


def limit(robot: Peer, most: float) -> None:
    robot.publish("limit", FLOAT, {"data": most})
    robot.expect_state(NODE, lambda s: s["variables"]["Limit.most"] == most)


def document(driver: Peer, topic: str, name: str) -> Any:
    def is_it(data: Any) -> bool:
        event = json.loads(data["data"])["event"]
        return (event["kind"], event["name"]) == ("request", name)

    heard = driver.expect("message", name=f"{NODE}/{topic}", where=is_it)
    found = json.loads(heard["data"]["data"])
    validate(found, {"events": "event"}.get(topic, topic))
    return found


def test_messages(robot: Peer, driver: Peer) -> None:
    limit(robot, 2.0)
    driver.publish("supervised/hoist", FLOAT, {"data": 5.0})
    assert robot.expect("message", name="hoist")["data"] == {"data": 2.0}
    told = document(driver, "events", "hoist")["corrected"]
    assert told["fields"] == {"data": {"sent": 5.0, "made": 2.0}}
    assert told["by"] == "provide hoist with min(value, Limit.most)"
    driver.publish("supervised/hoist", FLOAT, {"data": 1.5})
    assert robot.expect("message", name="hoist")["data"] == {"data": 1.5}
    assert "corrected" not in document(driver, "events", "hoist")
    robot.expect_state(NODE, lambda s: s["counters"]["corrected"] == 1)
    limit(robot, -1.0)
    driver.publish("supervised/hoist", FLOAT, {"data": 5.0})
    refused = document(driver, "blocked", "hoist")
    assert refused["corrected"]["fields"] == {"data": {"sent": 5.0, "made": -1.0}}
    (reason,) = refused["blocked_by"]
    assert reason["text"] == "requirement hoist needs value >= 0.0"
    assert robot.events("message", name="hoist") == []


def test_goals(robot: Peer, driver: Peer) -> None:
    limit(robot, 2.0)
    goal = {"name": "supervised/reach", "type": MOVE, "data": {"target": 7.0}}
    driver.order("send_goal", **goal)
    sent = robot.expect("goal", name="reach")
    assert sent["data"] == {"target": 2.0}
    assert driver.expect("answer", name="supervised/reach")["accepted"]
    told = document(driver, "events", "reach")["corrected"]
    assert told["fields"] == {"target": {"sent": 7.0, "made": 2.0}}
    robot.order("tell_server", id=sent["id"], end="succeed", result={"code": 0, "reached": 2.0})
    assert driver.expect("result", name="supervised/reach")["data"]["reached"] == 2.0
    limit(robot, -1.0)
    driver.order("send_goal", **goal)
    assert not driver.expect("answer", name="supervised/reach")["accepted"]
    refused = document(driver, "blocked", "reach")
    assert refused["corrected"]["fields"] == {"target": {"sent": 7.0, "made": -1.0}}
    assert robot.events("goal") == []


def test_calls(robot: Peer, driver: Peer) -> None:
    limit(robot, -1.0)
    call = {"name": "supervised/brake", "type": SWITCH, "data": {"data": False}}
    driver.order("start_call", **call)
    request = robot.expect("request", name="brake")
    assert request["data"] == {"data": True}
    robot.order("tell_server", id=request["id"], data={"success": True, "message": "m"})
    assert driver.expect("response")["data"] == {"success": True, "message": "m"}
    told = document(driver, "events", "brake")["corrected"]
    assert told["fields"] == {"data": {"sent": False, "made": True}}
    limit(robot, 2.0)
    assert driver.order("call", **call) == {"success": False, "message": ""}
    refused = document(driver, "blocked", "brake")
    assert "corrected" not in refused
    (reason,) = refused["blocked_by"]
    assert reason["text"] == "requirement brake needs value.data"
    assert robot.events("request") == []
