"""The robots of the gallery do their tasks in MuJoCo, with faults planted, and without a violation."""

from __future__ import annotations

import json
from collections.abc import Iterator
from pathlib import Path

import pytest

import gallery

pytestmark = pytest.mark.slow

LONG = {"corridor": 2.4, "follow_wall": 3.0, "maze": 2.4, "pick_and_place": 0.8}
"""What is not driven to its end, but so many metres: through the corridor once, the hand of the arm
with a part to its box. In how much simulated time depends on the machine, for a lost server is noticed
after seconds of real time."""


@pytest.fixture(scope="module")
def ros1(ros: None, tmp_path_factory: pytest.TempPathFactory) -> Iterator[gallery.Ros1]:
    """All controllers, built, and a master."""
    reason = gallery.missing()
    if reason is not None:
        pytest.skip(reason)
    built = gallery.Ros1(tmp_path_factory.mktemp("gallery") / "ros1")
    built.build(gallery.names())
    with built.running():
        yield built


@pytest.mark.parametrize("robot", gallery.names())
def test_robot_does_its_task_and_violates_nothing(
    robot: str, ros1: gallery.Ros1, tmp_path: Path
) -> None:
    ros1.drive(robot, 1, True, tmp_path / "run.json", LONG.get(robot))
    run = json.loads((tmp_path / "run.json").read_text(encoding="utf-8"))
    assert run["faults"]
    assert run["violations"] == {}
    if robot in LONG:
        assert run["moved"] >= LONG[robot], run["path"][-1]
    else:
        assert run["succeeded"], run["path"][-1]
    assert run["judgements"] > 20
