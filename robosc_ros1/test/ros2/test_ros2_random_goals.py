"""Goals that are replaced and cancelled at random on ROS 2: the controller knows when they run."""

from __future__ import annotations

import os
from collections.abc import Callable
from pathlib import Path
from typing import Any

from random_goals import followed
from ros2.bed import HERE
from ros2.ros2_support import Graph, Process
from ros_support import await_condition

GOALS = int(os.environ.get("ROBOSC_GOALS", "300"))


def at_rest(state: dict[str, Any]) -> bool:
    return state["communications"]["go"] == "idle" and not state["variables"]["Desk.open"]


def test_goals_that_are_replaced_and_cancelled_at_random(
    graph: Graph, controller: Callable[..., Process], tmp_path: Path
) -> None:
    events, told = tmp_path / "events.jsonl", tmp_path / "goals.txt"
    node = HERE / "random_goals_node.py"
    server = graph.start(graph.bed.python, node, "7", str(GOALS), told)
    qos = {f"qos__{name}__reliability": "reliable" for name in ("place", "wanted")}
    more = {"event_log": str(events), "event_log_size": 1000.0, "rate__go": 100.0}
    controller("courier_controller", **qos, **more)
    await_condition(lambda: "enough" in server.output, "all goals", 60.0 + GOALS / 5)
    robot = graph.peer()
    robot.watch("courier_controller")  # now, or a state of the beginning would pass for the end
    robot.expect_state("courier_controller", at_rest)
    found = followed(events, told)
    assert found.wrong == ()
    assert found.replaced > GOALS / 20
    assert all(found.counts.values()), found.counts
