"""A robot of the gallery drives in MuJoCo on real rclpy; in CI all of them do on ROS 1."""

from __future__ import annotations

import json
import os
from pathlib import Path

import pytest
from ros2.bed import Bed

import gallery


def test_robot_follows_a_person_and_violates_nothing(bed: Bed, tmp_path: Path) -> None:
    reason = gallery.missing()
    if reason is not None:
        pytest.skip(reason)
    ros2 = gallery.Ros2(tmp_path / "workspace")
    ros2.build(["follow_person"])
    with ros2.running():
        ros2.drive("follow_person", 1, True, tmp_path / "run.json")
    run = json.loads((tmp_path / "run.json").read_text(encoding="utf-8"))
    assert run["violations"] == {}
    assert run["succeeded"], run["path"][-1]
    assert run["judgements"] > 20
    assert run["simulated"] <= 20.0


IN_ORDER = """
from rclpy.executors import SingleThreadedExecutor
import rclpy
from physics.ros2 import Inbox

rclpy.init()
executor, called = SingleThreadedExecutor(), []
inbox = Inbox(executor)
for number in range(5):
    inbox.put(lambda number=number: called.append(number))
while len(called) < 5:
    executor.spin_once()
print(called)
"""


def test_what_an_action_server_is_told_it_does_in_that_order(bed: Bed, tmp_path: Path) -> None:
    """rclpy calls the newest task first: feedback came after the end of its goal."""
    path = os.pathsep.join((str(gallery.HERE), bed.environment["PYTHONPATH"]))
    told = Bed(bed.folder)
    told.environment["PYTHONPATH"] = path
    assert told.run(told.python, "-c", IN_ORDER, folder=tmp_path).strip() == "[0, 1, 2, 3, 4]"
