"""Which ROS a node is looked for in: what was sourced, what this Python has."""

from __future__ import annotations

import sys
from pathlib import Path

import pytest

from robosc.errors import UsageError
from robosc.view.node import which_ros


@pytest.fixture
def libraries(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """A folder that is the only one from which this Python loads modules now."""
    monkeypatch.setattr(sys, "path", [str(tmp_path)])
    for name in ("rospy", "rclpy"):
        monkeypatch.delitem(sys.modules, name, raising=False)
    return tmp_path


@pytest.mark.parametrize(
    ("there", "environment", "version"),
    [
        (["rospy"], {}, "1"),
        (["rclpy"], {}, "2"),
        (["rospy", "rclpy"], {"ROS_VERSION": "1"}, "1"),
        (["rospy", "rclpy"], {"ROS_VERSION": "2", "ROS_MASTER_URI": "http://localhost:1"}, "2"),
        (["rospy", "rclpy"], {"ROS_MASTER_URI": "http://localhost:1"}, "1"),
        (["rospy", "rclpy"], {}, "2"),
        (["rclpy"], {"ROS_VERSION": "seven"}, "2"),
    ],
)
def test_what_was_sourced_comes_before_what_is_there(
    there: list[str], environment: dict[str, str], version: str, libraries: Path
) -> None:
    for name in there:
        (libraries / f"{name}.py").touch()
    assert which_ros(environment) == version


@pytest.mark.parametrize(
    ("there", "environment", "words"),
    [
        ([], {}, "no rospy and no rclpy"),
        (["rospy"], {"ROS_VERSION": "2"}, "no rclpy:"),
        (["rclpy"], {"ROS_VERSION": "1"}, "no rospy:"),
    ],
)
def test_a_python_without_it_is_told(
    there: list[str], environment: dict[str, str], words: str, libraries: Path
) -> None:
    for name in there:
        (libraries / f"{name}.py").touch()
    with pytest.raises(UsageError, match=words):
        which_ros(environment)
