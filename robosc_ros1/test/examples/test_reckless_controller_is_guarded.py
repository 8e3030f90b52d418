"""A reckless controller written by hand breaks the requirements, and none of them when guarded."""

from __future__ import annotations

import json
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest
from ros_support import Master, Workspace

Drive = Callable[[bool], dict[str, Any]]


@pytest.fixture
def drive(example_workspace: Workspace, roscore: Master, tmp_path: Path) -> Drive:
    """Runs the example; what the observer saw."""

    def run(guarded: bool) -> dict[str, Any]:
        report = tmp_path / "summary.json"
        arguments = {"guarded": str(guarded).lower(), "speed": 2.0, "seed": 1, "metres": 3.5}
        arguments |= {"seconds": 60 if guarded else 8, "report": report}
        if guarded:  # so late may the observer hear of things on a busy machine
            arguments |= {"tolerance": 0.5}
        done = example_workspace.run(
            "roslaunch",
            "line_follower",
            "guarded.launch",
            *(f"{name}:={value}" for name, value in arguments.items()),
            master=roscore,
            check=False,
        )
        assert report.is_file(), f"{done.stdout}\n{done.stderr}"
        summary: dict[str, Any] = json.loads(report.read_text(encoding="utf-8"))
        return summary

    return run


def test_guarded_it_breaks_no_requirement_and_gets_on(drive: Drive) -> None:
    summary = drive(True)
    assert sum(summary["violations"].values()) == 0, summary["violations"]
    assert summary["metres"] >= 3.5
    assert summary["grabs"] >= 1
    assert summary["light_switches"] >= 3


def test_unguarded_it_breaks_many(drive: Drive) -> None:
    violations = drive(False)["violations"]
    assert sum(violations.values()) > 20
    assert violations["grab needs a halted robot"] > 0
    assert violations["move needs a free way"] > 0
