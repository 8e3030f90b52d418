"""The test of a package finds what a controller does wrong with the calls that it serves."""

from __future__ import annotations

from collections import deque
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest
from emit.golden_packages import GOLDEN, model_path
from emit.judged_controllers import judged, judging_model

FAULTS = {
    "accepts what no component takes": (
        'if not (self.switch == "ready" and value["data"] != self.switch_on)',
        "if False",
    ),
    "refuses what a component takes": ('value["data"] != self.switch_on)', "False)"),
    "answers against a requirement": ("return self.door_open", "return True"),
    "answers with other data": ('"message": "done"', '"message": "gone"'),
    "goes elsewhere": ('self.orders = "asked"', 'self.orders = "unwanted"'),
    "answers with an error": ('return self.orders == "unwanted"', 'return self.orders == "asked"'),
}


@pytest.fixture(scope="module")
def judging(tmp_path_factory: pytest.TempPathFactory) -> Iterator[tuple[Any, str]]:
    text = model_path("orders").read_text(encoding="utf-8")
    with judging_model(tmp_path_factory.mktemp("judge"), text) as found:
        yield found


@pytest.mark.parametrize("fault", FAULTS)
def test_it_finds(judging: tuple[Any, str], fault: str) -> None:
    judge, source = judging
    right, wrong = FAULTS[fault]
    assert right in source
    assert judged(judge, source.replace(right, wrong)).faults != []


def test_ends_of_two_cancelled_goals_are_told_one_by_one(tmp_path: Path) -> None:
    """Goals overlap for a moment where another controller sends them."""
    text = (GOLDEN.parent / "ros1/lifter.rscd").read_text(encoding="utf-8")
    with judging_model(tmp_path, text) as (judging, source):
        judge = judged(judging, source, rounds=1)
        action = next(c for c in judging.PLANT["communications"] if c["kind"] == "action")
        key = action["key"]
        judge.events["cancel", action["name"], 0] = 2
        judge.robot.sent[key, "cancelled"] = deque(["first", "second"])
        assert judge.come("cancelled", key, None) == "first"
        assert judge.come("cancelled", key, None) == "second"
