"""robosc against the oracle on random robots.

A run of ``pytest … --models 5000 --first-model 1000`` tries that many seeds from there on; without
the option it is about a minute's worth.
"""

from __future__ import annotations

import random
import re

import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from random_models import models, random_model
from synthesis.differential import ENGINES, differences
from synthesis.subject import oracle_of

from robosc.synthesis.bdd.manager import available, install_hint

pytestmark = pytest.mark.slow


def each_of(*engines: str) -> pytest.MarkDecorator:
    """One case for each of the engines, skipped where it is not there."""
    reason = f"no symbolic engine: {install_hint()}"
    return pytest.mark.parametrize(
        "engine",
        [
            pytest.param(e, marks=pytest.mark.skipif(e == "bdd" and not available(), reason=reason))
            for e in engines
        ],
    )


engines = each_of(*ENGINES)
SMALL = 2000
"""States of the largest plants that are tried unless ``--models`` says how many: one of ten thousand
takes as long as a hundred of them."""


def check(text: str, engine: str, seed: int | None = None, most: int | None = None) -> None:
    """Compare, unless more states than ``most`` can be reached."""
    oracle = oracle_of(text)
    if most is not None and not oracle.has_at_most(most):
        return
    found = differences(oracle.robot, oracle, engine)
    assert not found, "\n".join([f"seed {seed}, engine {engine}", text, *found[:20]])


@engines
@settings(
    max_examples=40,
    suppress_health_check=list(HealthCheck),
)
@given(text=models(st.integers(1, 2)))
def test_random_robots_shrinking(engine: str, text: str) -> None:
    check(text, engine)


@pytest.mark.timeout(0)
@engines
def test_random_robots_by_seed(engine: str, pytestconfig: pytest.Config) -> None:
    count = pytestconfig.getoption("--models", default=None)
    first = pytestconfig.getoption("--first-model", default=0)
    for seed in range(first, first + (45 if count is None else count)):
        check(random_model(random.Random(seed), 1 + seed % 3), engine, seed)


def test_random_robots_whose_goals_are_replaced() -> None:
    """The oracle reads by itself that a busy action takes a request."""
    tried = 0
    for seed in range(40):
        text = random_model(random.Random(seed), 1 + seed % 2)
        replaced = re.sub(r"(action \w+ with )", r"\1goals: replace, ", text)
        if replaced != text:
            tried += 1
            for engine in ENGINES if available() else ("explicit",):
                check(replaced, engine, seed)
    assert tried > 5


@engines
def test_a_hidden_transition_whose_guard_reads_what_no_event_has(engine: str) -> None:
    """A state's own transition is taken for sure, and hides the guarded one with a goto."""
    check(random_model(random.Random(910329), 1), engine, 910329)


def test_random_robots_are_of_all_sorts() -> None:
    """The comparison means something: supervisors that are empty, restricting, and trivial."""
    seen = set()
    for seed in range(80):
        oracle = oracle_of(random_model(random.Random(seed), 1 + seed % 3))
        seen.add("empty" if oracle.empty else "not empty")
        if not oracle.empty:
            seen |= {oracle.status(event) for event in oracle.events if event.controllable}
            if len(oracle.controlled[0]) < len(oracle.plant[0]):
                seen.add("fewer states")
    assert seen == {"empty", "not empty", "as required", "restricted", "never", "fewer states"}
