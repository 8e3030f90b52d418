"""A supervisor that corrects messages, calls and goals of a controller, on a real roscore."""

from __future__ import annotations

import json
from collections.abc import Iterator
from typing import Any

import pytest
from ros1.stage import Node, Puppet, Stage
from runtime.schemas import validate

NODE = "crane_supervisor"
FLOAT = "std_msgs/Float32"
LEVEL = {"name": "/supervised/set_level", "type": "gauntlet_interfaces/SetLevel"}
REACH = {"type": "gauntlet_interfaces/ReachAction"}


@pytest.fixture
def robot(crane: Stage) -> Iterator[Puppet]:
    with crane.puppet() as running:
        running.do("listen", topic="/hoist", type=FLOAT)
        running.do("service", name="/set_level", type=LEVEL["type"])
        running.do("action", name="/reach", **REACH, mode="hold")
        yield running


@pytest.fixture
def driver(crane: Stage) -> Iterator[Puppet]:
    with crane.puppet() as running:
        running.do("listen", topic=f"/{NODE}/blocked", type="std_msgs/String")
        yield running


@pytest.fixture
def node(crane: Stage, robot: Puppet, driver: Puppet) -> Iterator[Node]:
    with crane.controller(driver, NODE) as running:
        yield running


def limit(node: Node, robot: Puppet, most: float) -> None:
    # More than once: a publisher does not wait for its subscribers.
    robot.publish("/limit", FLOAT, most, times=20, rate=20.0)
    node.shows(lambda s: s["variables"]["Limit.most"] == most)


def corrected(node: Node, name: str) -> Any:
    told = node.tells(lambda e: e["event"]["name"] == name and e["event"]["kind"] == "request")
    validate(told, "event")
    return told.get("corrected")


def blocked(driver: Puppet, name: str, since: int = 0) -> Any:
    def is_it(message: Any) -> bool:
        return bool(json.loads(message["data"])["event"]["name"] == name)

    document = json.loads(driver.hears(f"/{NODE}/blocked", is_it, since=since)["data"])
    validate(document, "blocked")
    return document


def asked(robot: Puppet, name: str) -> Any:
    return robot.wait(lambda line: line.get("asked") == name, f"a request of {name}")


def test_messages(node: Node, robot: Puppet, driver: Puppet) -> None:
    limit(node, robot, 2.0)
    driver.publish("/supervised/hoist", FLOAT, 5.0)
    assert robot.hears("/hoist")["data"] == 2.0
    told = corrected(node, "hoist")
    assert told["fields"] == {"data": {"sent": 5.0, "made": 2.0}}
    assert told["by"] == "provide hoist with min(value, Limit.most)"
    driver.publish("/supervised/hoist", FLOAT, 1.5)
    robot.hears("/hoist", lambda m: m["data"] == 1.5)
    node.shows(lambda s: (s["counters"]["commands"], s["counters"]["corrected"]) == (2, 1))
    limit(node, robot, -1.0)
    driver.publish("/supervised/hoist", FLOAT, 5.0)
    document = blocked(driver, "hoist")
    assert document["corrected"]["fields"] == {"data": {"sent": 5.0, "made": -1.0}}
    (reason,) = document["blocked_by"]
    assert reason["text"] == "requirement hoist needs value >= 0.0"
    assert [m["data"] for m in robot.all_heard("/hoist")] == [2.0, 1.5]


def test_goals(node: Node, robot: Puppet, driver: Puppet) -> None:
    limit(node, robot, 2.0)
    goal = {"name": "/supervised/reach", **REACH}
    driver.do("send", **goal, fields={"height": 7})
    assert asked(robot, "/reach")["message"]["height"] == 2
    assert corrected(node, "reach")["fields"] == {"height": {"sent": 7, "made": 2}}
    robot.do("finish", name="/reach", mode="succeed")
    driver.wait(lambda line: line.get("ended") and line["status"] == 3, "its success")
    limit(node, robot, -1.0)
    mark = driver.mark
    driver.do("send", **goal, fields={"height": 7})
    document = blocked(driver, "reach", mark)
    assert document["corrected"]["fields"] == {"height": {"sent": 7, "made": -1}}
    driver.wait(lambda line: line.get("ended") and line["status"] == 5, "its rejection", since=mark)


def test_calls(node: Node, robot: Puppet, driver: Puppet) -> None:
    limit(node, robot, -1.0)
    driver.do("call", **LEVEL, fields={"level": -3})
    assert asked(robot, "/set_level")["message"] == {"level": 1}
    assert corrected(node, "set_level")["fields"] == {"level": {"sent": -3, "made": 1}}
    driver.wait(lambda line: line.get("answered") and "message" in line, "the response")
    limit(node, robot, 2.0)
    mark = driver.mark
    driver.do("call", **LEVEL, fields={"level": -3})
    document = blocked(driver, "set_level")
    assert "corrected" not in document
    (reason,) = document["blocked_by"]
    assert reason["text"] == "requirement set_level needs value.level > 0"
    failed = driver.wait(lambda line: line.get("answered"), "the failure", since=mark)
    assert "requirement set_level needs" in failed["failure"]


def test_a_number_too_large_for_its_field(node: Node, robot: Puppet, driver: Puppet) -> None:
    robot.do("listen", topic="/gear", type="std_msgs/Int8")
    driver.publish("/supervised/gear", "std_msgs/Int8", 2)
    (reason,) = blocked(driver, "gear")["blocked_by"]
    assert reason == {"kind": "data", "text": "field data exceeds specified width [int8]"}
    driver.publish("/supervised/gear", "std_msgs/Int8", 1)
    assert robot.hears("/gear")["data"] == 100
    node.shows(lambda s: s["stopped"] is None and s["counters"]["blocked"] == 1)
