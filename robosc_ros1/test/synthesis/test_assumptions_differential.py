"""robosc against the oracle on random robots of which something is assumed."""

from __future__ import annotations

import random

import pytest
from random_models import random_model
from synthesis.test_oracle_differential import check, engines


def _model(seed: int) -> str:
    return random_model(random.Random(seed), 1 + seed % 3, assumes=True)


@pytest.mark.slow
@pytest.mark.timeout(0)
@engines
def test_random_robots_with_assumptions(engine: str, pytestconfig: pytest.Config) -> None:
    count = pytestconfig.getoption("--models", default=None)
    first = pytestconfig.getoption("--first-model", default=0)
    for seed in range(first, first + (150 if count is None else count)):
        check(_model(seed), engine, seed)
