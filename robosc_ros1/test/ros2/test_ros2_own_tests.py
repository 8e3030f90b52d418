"""The tests that packages of ROS 2 bring pass."""

from __future__ import annotations

from typing import Any

import pytest
from ros2.ros2_support import Graph


@pytest.mark.parametrize(
    "package",
    [
        "dispatch_controller",
        "everything_controller",
        "missions_controller",
        "courier_controller",
        "courier_supervisor",
        "courier_monitor",
        "sentry_supervisor",
        "mirror_controller",
        "mirror_supervisor",
        "mirror_monitor",
        "guarded_arm_monitor",
        "hoist_monitor",
    ],
)
def test_what_a_node_does_is_judged(graph: Graph, built: Any, package: str) -> None:
    test = graph.start(
        graph.bed.python, "-m", "pytest", "-q", "-s", "-p", "no:cacheprovider",
        built.folder / "src" / package / "test",
        **built.environment(package),
    )  # fmt: skip
    assert test.wait(240.0) == 0, test.output
