"""The test of a package finds what a controller does wrong with the calls that it serves."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

import pytest
from emit.golden_packages import model_path
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
