"""Going forward only over states that violate no requirement gives the same controlled system, as
does taking them from the explicit engine."""

from __future__ import annotations

import random

import pytest
import steep_families
from random_models import random_model
from synthesis.plants import plant_of
from synthesis.same_solutions import assert_same

from robosc.synthesis.bdd.symbolic_engine import SymbolicEngine
from robosc.synthesis.explicit.explicit_engine import ExplicitEngine

pytest.importorskip("oxidd", reason="the symbolic engine needs the Python package oxidd")

SMALL = 2**25


@pytest.mark.parametrize("seeds", [range(100), range(100, 200)])
def test_the_same_controlled_system(seeds: range) -> None:
    restricted = empty = 0
    for seed in seeds:
        plant = plant_of(random_model(random.Random(seed), 1 + seed % 3))
        usual = SymbolicEngine(plant, memory=SMALL).solve()
        other = SymbolicEngine(plant, memory=SMALL, invariants_first=True).solve()
        assert other.empty == usual.empty
        empty += usual.empty
        if usual.empty:
            continue
        restricted += usual.restricted
        assert_same(usual, other)
        explicit = ExplicitEngine(plant)
        explicit.solve(lambda found, left, steps: None)
        given = explicit.found.states
        assert_same(usual, SymbolicEngine(plant, memory=SMALL, invariants_first=True).solve(given))
    assert restricted > 10 and empty > 5


def test_an_event_applies_the_requirements_that_it_may_violate() -> None:
    """All requirements of the family read what a robot holds, which taking a tool changes."""
    plant = plant_of(steep_families.one_tool_each(3, 4))
    engine = SymbolicEngine(plant, memory=SMALL, invariants_first=True)
    applied = {plant.events[e.number].name: len(engine._touched[e.number]) for e in engine.events}
    assert len(plant.invariants) == 4
    assert {name: n for name, n in applied.items() if n} == {
        f"Robot[{i}].take{k}": 1 for i in (1, 2, 3) for k in (1, 2, 3, 4)
    }
