"""The robots of the gallery do their tasks in MuJoCo, with faults planted, and without a violation."""

from __future__ import annotations

import json
import math
from collections.abc import Iterator
from itertools import pairwise
from pathlib import Path

import pytest

import gallery

pytestmark = pytest.mark.slow

LONG = {"corridor": 2.4, "follow_wall": 3.0, "maze": 2.4, "pick_and_place": 0.3}
"""What is not done within the 20 seconds of simulated time, and how many metres it has moved then at
least: through the corridor once, the hand of the arm with a part to its box."""


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
    ros1.drive(robot, 1, True, tmp_path / "run.json", seconds=20.0)
    run = json.loads((tmp_path / "run.json").read_text(encoding="utf-8"))
    assert run["faults"]
    assert run["violations"] == {}
    if robot in LONG:
        assert length(run["path"]) > LONG[robot], run["path"][-1]
    else:
        assert run["succeeded"], run["path"][-1]
    assert run["judgements"] > 20


def length(path: list[list[float]]) -> float:
    """Return the length of a path in metres."""
    return sum(math.dist(here, there) for here, there in pairwise(path))
