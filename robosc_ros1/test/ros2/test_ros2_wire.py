"""An observer on the wire of nodes of rclpy: see ``wire.py``; ``./dev bench wire`` tries all cells."""

from __future__ import annotations

from functools import partial
from pathlib import Path

import pytest
import wire
from ros2 import wired2
from ros2.bed import Bed
from ros_support import built_once


@pytest.fixture(scope="session")
def made(bed: Bed, tmp_path_factory: pytest.TempPathFactory) -> Path:
    return built_once(tmp_path_factory, "wired2", partial(wired2.packages, bed))


@pytest.mark.parametrize("event", wire.EVENTS)
@pytest.mark.parametrize(("mode", "server"), [("controller", "slow"), ("supervisor", "late")])
def test_nothing_arrives_that_is_not_allowed(
    made: Path, bed: Bed, tmp_path: Path, mode: str, server: str, event: str
) -> None:
    with wired2.world(made, mode, event, bed, tmp_path) as world:
        assert wire.faults(world, server, event) == []
