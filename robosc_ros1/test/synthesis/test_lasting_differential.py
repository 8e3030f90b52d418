"""robosc against the oracle on random robots with conditions that must have held for some time."""

from __future__ import annotations

import random
import re

import pytest
from random_models import random_model
from synthesis.subject import robot_of
from synthesis.test_oracle_differential import check, engines

_NEEDS = re.compile(r"^( *requirement (?!always|never).* needs )(.*)$", re.MULTILINE)


def lasting_model(seed: int) -> str:
    """A random robot; what some of its commands need must have held for a second."""
    chance = random.Random(seed)
    conditions: list[str] = []

    def lasting(found: re.Match[str]) -> str:
        if "value" in found[2] or found[2].endswith(" to start") or chance.random() < 0.2:
            return found[0]
        conditions.append(f"    condition lasting{len(conditions)} = {found[2]} for 1 s")
        return f"{found[1]}lasting{len(conditions) - 1}"

    text = _NEEDS.sub(lasting, random_model(chance, 1 + seed % 2))
    end = text.rstrip().rindex("}")
    return "\n".join([text[:end].rstrip(), *conditions, "}", ""])


def test_the_models_have_some() -> None:
    assert sum(len(robot_of(lasting_model(seed)).lasting) for seed in range(20)) > 5


@pytest.mark.slow
@pytest.mark.timeout(0)
@engines
def test_random_robots_with_lasting_conditions(engine: str, pytestconfig: pytest.Config) -> None:
    count = pytestconfig.getoption("--models", default=None)
    first = pytestconfig.getoption("--first-model", default=0)
    for seed in range(first, first + (40 if count is None else count)):
        check(lasting_model(seed), engine, seed)
