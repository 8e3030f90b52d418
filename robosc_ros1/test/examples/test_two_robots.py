"""Two simulated robots, one generated controller: an hour of simulated time."""

from __future__ import annotations

import json
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest
from ros_support import EXAMPLES, Completed, Master, Workspace
from simulate.players import session

from robosc import pipeline

FOLDER = EXAMPLES / "two_robots"
MODEL = FOLDER / "two_robots.rscd"

ROBOTS = ("Robot[1]", "Robot[2]")


def test_synthesis_finds_who_must_wait(robosc: Callable[..., Completed]) -> None:
    """Only that is told: who waits for whom stands in no requirement."""
    done = robosc("check", str(MODEL), "--json")
    assert done.returncode == 0
    (found,) = json.loads(done.stdout)["diagnostics"]
    assert found["code"] == "restricted-command"
    head = "cross.request of each Robot is restricted further: with Robot[1], after "
    assert found["message"].startswith(head)


def judged(found: dict[str, Any]) -> None:
    """The floor has seen an hour in which both robots worked, and nothing that must not be."""
    assert sum(found["violations"].values()) == 0, found
    assert found["seconds"] >= 3600
    for counts in found["robots"]:
        assert counts["cross"] >= 4 and counts["failed"] >= 1, found
        assert counts["dock"] >= 1 and counts["undock"] >= 1, found


@pytest.mark.parametrize("seed", range(2))
def test_an_hour_on_a_virtual_clock(seed: int, monkeypatch: pytest.MonkeyPatch) -> None:
    """The controller as it executes, without ROS, hears of the floor every two seconds."""
    monkeypatch.syspath_prepend(FOLDER / "src")
    from two_robots.floor import Floor

    floor = Floor(seed)
    player = session(pipeline.supervise(pipeline.load(MODEL).robot), execute=True)

    def hear(line: str) -> None:
        """Something reaches the controller; what it then asks for begins on the floor."""
        for happening in player.do(line).happenings:
            if happening.kind == "request":
                name, job = happening.name.split(".")
                floor.begin(ROBOTS.index(name), job)

    while floor.time < 3600:
        for name, robot in zip(ROBOTS, floor.robots, strict=True):
            hear(f"{name}.battery {robot.battery}")
        hear("wait 2")
        jobs = [*floor.jobs]
        for number, how in floor.step(2.0).items():
            event = "response" if how == "done" else "error"
            hear(f"{ROBOTS[number]}.{jobs[number]}.{event}")
    judged(floor.report())
    assert floor.longest_rest <= 4, "nobody works although somebody could"


def test_an_hour_on_a_roscore(
    example_workspace: Workspace, roscore: Master, tmp_path: Path
) -> None:
    """About 10 s: 600 simulated seconds go by in each."""
    report = tmp_path / "floor.json"
    launch = ("roslaunch", "two_robots_example", "two_robots.launch")
    example_workspace.run(*launch, "speed:=600", f"report:={report}", master=roscore, check=False)
    judged(json.loads(report.read_text(encoding="utf-8")))
