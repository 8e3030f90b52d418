"""Silence of sensors, delayed transitions, and topics of several communications, on a roscore."""

from __future__ import annotations

from typing import Any

from ros1.stage import Node, Puppet, Stage, event, stopped

NODE = "watch_controller"
SCAN = {"topic": "/scan", "type": "std_msgs/Float32", "fields": {"data": 5.0}}
INT = "std_msgs/Int16"


def count(state: dict[str, Any], name: str) -> int:
    """How often a command was sent."""
    return next(int(c["count"]) for c in state["commands"] if c["event"]["name"] == name)


def drives(node: Node) -> dict[str, Any]:
    """The state in which the scan is fresh and the robot has driven."""
    return node.shows(lambda s: s["communications"]["scan"] == "fresh" and count(s, "drive") > 2)


def test_a_killed_sensor_stops_the_robot(stage: Stage, ear: Puppet) -> None:
    with stage.controller(ear, NODE) as node:
        with stage.puppet() as sensor:
            sensor.begin("publish", **SCAN, times=10_000, rate=50.0)
            drives(node)
            sensor.process.kill()
            silent = node.tells(event("timeout", "scan"))
        heard = node.events(event("response", "scan"))[-1]
        assert silent["time"] - heard["time"] >= 0.49
        # It was not allowed to halt while it drove; now it does, again and again.
        mark = ear.mark
        for _ in range(3):
            node.tells(event("after", "Motor", value="rest->ready"), since=mark)
            node.tells(event("request", "halt"), since=mark)
            mark = ear.mark
        driven = node.events(event("request", "drive"))
        assert driven
        assert all(drive["number"] < silent["number"] for drive in driven)
        assert len(node.events(event("timeout", "scan"))) == 1


def test_a_sensor_that_stood_still_and_comes_back_with_a_burst(stage: Stage, ear: Puppet) -> None:
    with stage.controller(ear, NODE) as node, stage.puppet() as sensor:
        sensor.begin("publish", **SCAN, times=10_000, rate=50.0)
        drives(node)
        with stopped(sensor.process.pid):
            silent = node.tells(event("timeout", "scan"))
            node.tells(event("request", "halt"))
            mark = ear.mark
        node.tells(event("response", "scan"), since=mark)
        node.tells(event("request", "drive"), since=mark)
        node.shows(lambda s: s["communications"]["scan"] == "fresh", since=mark)
        assert node.events(event("timeout", "scan")) == [silent]


def test_a_topic_of_two_communications_is_one_input(
    stage: Stage, puppet: Puppet, ear: Puppet
) -> None:
    with stage.controller(ear, NODE, publish_events=False) as node:
        puppet.publish("/way", INT, -1)
        before = node.shows(lambda s: s["variables"]["Way.back"])
        mark = ear.mark
        signs = {"fields": {"data": 1}, "other": {"data": -1}}
        puppet.do("publish", topic="/way", type=INT, **signs, times=10_000, rate=2000.0)
        after = node.shows(lambda s: s["counters"]["inputs"] >= 20_002, since=mark)
        assert after["counters"]["dropped"] == 0
        assert count(after, "stay") == count(before, "stay")
