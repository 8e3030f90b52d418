"""The robots of the gallery do their tasks in MuJoCo, with faults planted, and without a violation."""

from __future__ import annotations

import json
from collections.abc import Iterator
from pathlib import Path

import pytest
from examples.test_gallery_bags import RECORDED, did_its_task

import gallery

pytestmark = pytest.mark.slow

LONG = {
    "corridor": 2.4,
    "follow_wall": 3.0,
    "inspection": 3.0,
    "maze": 2.4,
    "patrol": 3.0,
    "pick_and_place": 0.66,
}
"""What is not driven to its end, but so many metres: through the corridor once, the hand of the arm
with a part to its box."""
ROBOTS = [robot for robot in gallery.names() if robot not in RECORDED]


@pytest.fixture(scope="module")
def ros1(ros: None, tmp_path_factory: pytest.TempPathFactory) -> Iterator[gallery.Ros1]:
    """All controllers, built, and a master."""
    reason = gallery.missing()
    if reason is not None:
        pytest.skip(reason)
    built = gallery.Ros1(tmp_path_factory.mktemp("gallery") / "ros1")
    built.build(ROBOTS)
    with built.running():
        yield built


@pytest.mark.parametrize("robot", ROBOTS)
def test_robot_does_its_task_and_violates_nothing(
    robot: str, ros1: gallery.Ros1, tmp_path: Path
) -> None:
    ros1.drive(robot, 1, True, tmp_path / "run.json", LONG.get(robot))
    run = json.loads((tmp_path / "run.json").read_text(encoding="utf-8"))
    did_its_task(run, LONG.get(robot))


@pytest.mark.parametrize(
    ("type_", "checksum"),
    [
        ("control_msgs/FollowJointTrajectoryAction", "bc4f9b743838566551c0390c65f1a248"),
        ("control_msgs/GripperCommandAction", "950b2a6ebe831f5d4f4ceaba3d8be01e"),
        ("kobuki_msgs/BumperEvent", "ffe360cd50f14f9251d9844083e72ac5"),
    ],
)
def test_interface_is_that_of_the_real_package(
    type_: str, checksum: str, ros1: gallery.Ros1
) -> None:
    assert ros1.workspace.run("rosmsg", "md5", type_).stdout.strip() == checksum
