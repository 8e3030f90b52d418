"""What the nodes that measure on ROS 2 have in common."""

import contextlib
import json
import threading
from pathlib import Path

import rclpy
from rclpy.executors import ExternalShutdownException


@contextlib.contextmanager
def spinning(node):
    """Another thread spins the node, until ROS is shut down at the end."""
    thread = threading.Thread(target=_spin, args=(node,), daemon=True)
    thread.start()
    yield
    rclpy.try_shutdown()
    thread.join()


def _spin(node):
    with contextlib.suppress(ExternalShutdownException):
        rclpy.spin(node)


def write(found, file):
    """Write what was found as JSON."""
    with Path(file).open("w", encoding="utf-8") as stream:
        json.dump(found, stream)
