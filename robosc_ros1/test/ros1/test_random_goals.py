"""Goals that are replaced and cancelled at random on ROS 1: the controller knows when they run."""

from __future__ import annotations

import os
from pathlib import Path
from typing import Any

from random_goals import followed
from ros1.stage import Puppet, Stage
from ros_support import PYTHON, await_condition

GOALS = int(os.environ.get("ROBOSC_GOALS", "300"))


def at_rest(state: dict[str, Any]) -> bool:
    return state["communications"]["go"] == "idle" and not state["variables"]["Desk.open"]


def test_goals_that_are_replaced_and_cancelled_at_random(
    stage: Stage, ear: Puppet, tmp_path: Path
) -> None:
    events, told = tmp_path / "events.jsonl", tmp_path / "goals.txt"
    node = str(Path(__file__).with_name("random_goals_node.py"))
    more = {"event_log": events, "event_log_size": 1000.0, "rate__go": 100.0}
    with (
        stage.workspace.start(
            str(PYTHON), node, "7", str(GOALS), str(told), master=stage.master
        ) as server,
        stage.controller(ear, "courier_controller", **more) as controller,
    ):
        log: Path = server.log  # type: ignore[attr-defined]
        await_condition(lambda: "enough" in log.read_text(), "all goals", 60.0 + GOALS / 5)
        controller.shows(at_rest, since=ear.mark)
    found = followed(events, told)
    assert found.wrong == ()
    assert found.replaced > GOALS / 20
    assert all(found.counts.values()), found.counts
