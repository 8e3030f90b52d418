"""An observer on the wire of real nodes: see ``wire.py``; ``./dev bench wire`` tries all cells."""

from __future__ import annotations

from pathlib import Path

import pytest
import wire
from ros1 import wired
from ros_support import Master, built_once


@pytest.fixture(scope="session")
def made(ros: None, tmp_path_factory: pytest.TempPathFactory) -> Path:
    return built_once(tmp_path_factory, "wired", wired.packages)


@pytest.mark.parametrize("event", ["e-stop", "hold", "safe stop", "signal"])
@pytest.mark.parametrize(("mode", "server"), [("controller", "late"), ("supervisor", "slow")])
def test_nothing_arrives_that_is_not_allowed(
    made: Path, shared_master: Master, tmp_path: Path, mode: str, server: str, event: str
) -> None:
    with wired.world(made, mode, shared_master, tmp_path) as world:
        assert wire.faults(world, server, event) == []
