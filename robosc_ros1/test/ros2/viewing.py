"""``robosc view`` in a graph of ROS 2, and the address that it prints."""

from __future__ import annotations

import os
import re

from ros2.ros2_support import Graph, Process
from ros_support import SOURCES, await_condition

__all__ = ["address", "viewing"]


def viewing(graph: Graph, node: str, *words: str) -> Process:
    path = os.pathsep.join((str(SOURCES), graph.environment["PYTHONPATH"]))
    command = (graph.bed.python, "-m", "robosc", "view", "--ros", node, "--port", "0", *words)
    return graph.start(*command, PYTHONPATH=path)


def address(viewer: Process) -> str:
    def printed() -> str | None:
        assert viewer.popen.poll() is None, viewer.output
        found = re.search(r"http://\S+", viewer.output)
        return found and found[0]

    return str(await_condition(printed, "the address of the page"))
