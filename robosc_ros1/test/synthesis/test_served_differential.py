"""robosc against the oracle on random robots that call the controller."""

from __future__ import annotations

import random

import pytest
from random_models import random_model
from synthesis.subject import oracle_of
from synthesis.test_oracle_differential import check, engines

from robosc.language.events import EventKind

SERVED = (EventKind.ANSWER, EventKind.REFUSAL, EventKind.PROGRESS)

pytestmark = pytest.mark.slow


def _model(seed: int) -> str:
    return random_model(random.Random(seed), 1 + seed % 3, served=True)


@pytest.mark.timeout(0)
@engines
def test_random_robots_that_call_the_controller(engine: str, pytestconfig: pytest.Config) -> None:
    count = pytestconfig.getoption("--models", default=None)
    first = pytestconfig.getoption("--first-model", default=0)
    tried = 0
    for seed in range(first, first + (60 if count is None else count)):
        text = _model(seed)
        if "outgoing service" in text or "outgoing action" in text:
            check(text, engine, seed)
            tried += 1
    assert tried


def test_random_robots_are_of_all_sorts() -> None:
    """The comparison means something: calls are refused, accepted by their values, and answered."""
    seen: set[str] = set()
    for seed in range(60):
        text = _model(seed)
        if "outgoing service" not in text and "outgoing action" not in text:
            continue
        oracle = oracle_of(text)
        seen.add("empty" if oracle.empty else "not empty")
        if not oracle.empty:
            seen |= {
                f"{event.kind.word} {oracle.status(event)}"
                for event in oracle.events
                if event.kind in SERVED
            }
    assert {"empty", "not empty", "response as required", "error as required"} <= seen
    assert {"response restricted", "response never"} & seen
    assert {"feedback restricted", "feedback never"} & seen and "feedback as required" in seen
