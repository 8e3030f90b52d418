"""``./dev bench synthesis`` measures commands of this checkout, wherever Python looks by itself."""

from __future__ import annotations

import published_families
import pytest
from bench.synthesis_bench import command_time


def test_the_command_is_found_without_pythonpath(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.delenv("PYTHONPATH", raising=False)
    seconds, megabytes = command_time(published_families.rework(2, 2))
    assert seconds > 0 and megabytes > 0


def test_a_command_that_fails_tells_why() -> None:
    with pytest.raises(SystemExit, match="expected 'robot' or 'library'"):
        command_time("nonsense")
