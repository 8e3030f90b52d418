"""A monitor of a model that corrects commands, on real rclpy."""

from __future__ import annotations

import json
from collections.abc import Callable
from typing import Any

from ros2.ros2_support import Graph, Process
from ros_support import await_condition
from runtime.schemas import validate

NODE = "crane_monitor"
FLOAT = "std_msgs/msg/Float32"


def test_what_was_sent_and_what_it_would_have_become(
    graph: Graph, controller: Callable[..., Process]
) -> None:
    controller(NODE, qos__limit__reliability="reliable", qos__hoist__reliability="reliable")
    driver = graph.peer("driver")
    driver.watch(NODE)
    driver.subscribe(f"{NODE}/findings", "std_msgs/msg/String")
    driver.publish("limit", FLOAT, {"data": 2.0})
    driver.expect_state(NODE, lambda s: s["variables"]["Limit.most"] == 2.0)
    for height in (1.5, 5.0, -1.0):
        driver.publish("hoist", FLOAT, {"data": height})
    driver.expect_state(NODE, lambda s: s["counters"]["forbidden"] == 2)

    def found() -> list[Any]:
        heard = driver.events("message", name=f"{NODE}/findings")
        return [json.loads(one["data"]["data"]) for one in heard]

    await_condition(lambda: len(found()) >= 2, "the findings")
    for document in found():
        validate(document, "finding")
    assert [(d["sort"], d["event"]["value"]["data"]) for d in found()] == [
        ("corrected", 5.0), ("violation", -1.0)
    ]  # fmt: skip
    assert found()[0]["reasons"][0]["because"] == ["data 5.0 becomes 2.0"]
