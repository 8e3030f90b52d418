"""What robots of the gallery need of rclpy; test_gallery_bags drives them on it."""

from __future__ import annotations

import os
from pathlib import Path

from ros2.bed import Bed

import gallery

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
