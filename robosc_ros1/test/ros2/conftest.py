"""Fixtures of tests with ROS 2; see ros2_support.py."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

import pytest
from ros2.ros2_support import Bed, Graph, Unavailable, free_domain, test_bed


@pytest.fixture(scope="session")
def bed() -> Bed:
    """The test bed; skips where it is not to be had."""
    try:
        return test_bed()
    except Unavailable as reason:
        pytest.skip(f"no ROS 2: {reason}")


@pytest.fixture
def graph(bed: Bed, tmp_path: Path) -> Iterator[Graph]:
    """A ROS graph of the test's own."""
    with free_domain() as domain:
        graph = Graph(bed, domain, tmp_path)
        try:
            yield graph
        finally:
            graph.close()
