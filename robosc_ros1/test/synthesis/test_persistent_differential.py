"""robosc against the oracle on random robots with persistent variables: proved for every start."""

from __future__ import annotations

import random

import pytest
from random_models import random_model
from synthesis.subject import oracle_of
from synthesis.test_oracle_differential import check, engines

from robosc.pipeline import synthesize
from robosc.simulate.machines.event_by_event import SingleEvents
from robosc.simulate.start import supervisor_with
from robosc.synthesis.verify.verification import verify

pytestmark = pytest.mark.slow


def _model(seed: int) -> str:
    return random_model(random.Random(seed), 1 + seed % 2, stays=True)


@pytest.mark.timeout(0)
@engines
def test_random_robots_that_remember(engine: str, pytestconfig: pytest.Config) -> None:
    count = pytestconfig.getoption("--models", default=None)
    first = pytestconfig.getoption("--first-model", default=0)
    tried = 0
    for seed in range(first, first + (60 if count is None else count)):
        text = _model(seed)
        if "persistent" in text:
            check(text, engine, seed)
            tried += 1
    assert tried


def test_verify_is_about_every_start() -> None:
    """The independent check finds the same states; one start more would show."""
    starts = 0
    for seed in range(60):
        oracle = oracle_of(_model(seed))
        if not oracle.empty:
            supervisor = synthesize(oracle.robot)
            assert verify(supervisor).verified
            starts += len(oracle.initials)
    assert starts > 60


def test_simulations_start_with_any_value() -> None:
    """A run from any start is one of the plant, as far as the oracle enables events."""
    tried = 0
    for seed in range(60):
        oracle = oracle_of(_model(seed))
        if oracle.empty:
            continue
        supervisor = synthesize(oracle.robot)
        rng = random.Random(seed)
        for start in rng.sample(oracle.initials, min(4, len(oracle.initials))):
            values = {
                name: oracle.get(start, "var", name)
                for what, name in oracle.slots
                if what == "var" and oracle.variables[name].persistent
            }
            machine = SingleEvents(supervisor_with(supervisor, {}, values))
            found = {c.event for c in machine.choices() if c.event.controllable}
            assert {(e.kind, e.name, e.index) for e in found} == {
                (e.kind, oracle.name(e), e.index) for e in oracle.enabled(start)
            }
            tried += bool(values)
    assert tried > 40
