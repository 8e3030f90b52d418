"""Which version of ROS ``generate`` writes for, and that it says so."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import pytest
from ros_support import EXAMPLES, Completed

DOOR = str(EXAMPLES / "door" / "door.rscd")


@pytest.mark.parametrize(
    ("sourced", "arguments", "told", "file"),
    [
        ("", (), "for ROS 1 (ROS_VERSION is not set; --target ros2 for ROS 2)", "CMakeLists.txt"),
        ("1", (), "for ROS 1 (ROS_VERSION is 1)", "CMakeLists.txt"),
        ("2", (), "for ROS 2 (ROS_VERSION is 2)", "setup.cfg"),
        ("2", ("--target", "ros1"), "for ROS 1 (--target)", "CMakeLists.txt"),
        ("1", ("--target", "ros2"), "for ROS 2 (--target)", "setup.cfg"),
    ],
)
def test_target(
    robosc: Callable[..., Completed],
    tmp_path: Path,
    sourced: str,
    arguments: tuple[str, ...],
    told: str,
    file: str,
) -> None:
    done = robosc("generate", DOOR, *arguments, ROS_VERSION=sourced)
    assert f"door_controller: {told}, " in done.stdout
    assert (tmp_path / "door_controller" / file).is_file()
