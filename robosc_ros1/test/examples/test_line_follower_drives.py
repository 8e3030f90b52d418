"""The generated line follower drives the simulated robot on a real roscore, without a violation."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import pytest
from ros_support import Master, Workspace


@pytest.fixture
def summary(example_workspace: Workspace, roscore: Master, tmp_path: Path) -> Any:
    """What the observer saw of the first metres: a gap, an obstacle, a grab that fails first."""
    report = tmp_path / "summary.json"
    arguments = {"speed": 2.0, "seed": 1, "metres": 3.5, "seconds": 60, "report": report}
    arguments |= {"tolerance": 0.5}  # so late may the observer hear of things on a busy machine
    example_workspace.run(
        "roslaunch",
        "line_follower",
        "line_follower.launch",
        *(f"{name}:={value}" for name, value in arguments.items()),
        master=roscore,
        check=False,
    )
    return json.loads(report.read_text(encoding="utf-8"))


@pytest.mark.once
def test_line_follower_drives_halts_grabs_and_goes_on(summary: Any) -> None:
    assert sum(summary["violations"].values()) == 0, summary["violations"]
    assert summary["metres"] >= 3.5
    assert summary["stops"] >= 1
    assert summary["grabs"] >= 1
    assert summary["light_switches"] >= 3
    assert summary["commands_judged"] > 50
