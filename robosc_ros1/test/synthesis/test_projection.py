"""Folding dependent state variables: nothing but the memory changes."""

from __future__ import annotations

import random

import families
import pytest
from quick import quick_first
from random_models import random_model
from synthesis.plants import plant_of
from synthesis.subject import robot_of

from robosc.plant.automaton import Plant, PlantState
from robosc.plant.build import lower
from robosc.synthesis import explore
from robosc.synthesis.dense.bitset import places
from robosc.synthesis.dense.dense_engine import DenseEngine
from robosc.synthesis.dense.layout import Layout
from robosc.synthesis.dense.projection import projected_layout
from robosc.synthesis.dense.transitions import Compiler


def solved(plant: Plant, folded: bool) -> tuple[Layout, int, set[PlantState] | None]:
    """The layout, the plant's states, and the controlled ones one by one (None: empty)."""
    compiler = Compiler(plant)
    rules = [compiler.event(event) for event in plant.events]
    layout = projected_layout(plant, rules) if folded else Layout.plain(plant)
    engine = DenseEngine(compiler, rules, layout)
    solution = engine.solve()
    if solution.empty:
        return layout, engine.plant_states, None
    states = {layout.state(int(place)) for place in places(solution.states)}
    return layout, engine.plant_states, states


@pytest.mark.parametrize("seed", quick_first(range(60), 12))
def test_random_robots_have_the_same_states(seed: int) -> None:
    plant = lower(robot_of(random_model(random.Random(seed), 1 + seed % 3)))
    assert solved(plant, True)[1:] == solved(plant, False)[1:]


@pytest.mark.parametrize("seed", quick_first(range(60, 90), 8))
def test_every_reachable_state_has_a_place(seed: int) -> None:
    plant = lower(robot_of(random_model(random.Random(seed), 2)))
    compiler = Compiler(plant)
    layout = projected_layout(plant, [compiler.event(event) for event in plant.events])
    for state in explore(plant).states:
        place = layout.index(state)
        assert place is not None
        assert layout.state(place) == state


def test_component_that_mirrors_a_phase_costs_nothing() -> None:
    assert solved(plant_of(families.services_hands(5)), True)[0].size == 4**5


def test_values_never_taken_cost_nothing() -> None:
    plant = plant_of(
        "component A { outgoing message up with type: none incoming message go with type: none"
        " behaviour { variable x: integer(0..1000) initial marked state s {"
        " on response from up if x < 4 do x := x + 1 } } }"
        " requirement go needs A.x > 2"
    )
    assert solved(plant, True)[0].size == 5


def test_independent_state_variables_stay_apart() -> None:
    layout = solved(plant_of(families.hands(4)), True)[0]
    assert [dim.size for dim in layout.dims] == [2] * 8


def test_three_that_move_together_become_one() -> None:
    plant = plant_of(
        "component A { outgoing message up with type: none behaviour {"
        " initial marked state a { on response from up goto b }"
        " marked state b { on response from up goto a } } }"
        "component B { behaviour { variable seen: integer(0..1)"
        " initial marked state a { on response from up do seen := 1 goto b }"
        " marked state b { on response from up do seen := 0 goto a } }"
        " incoming message go with type: none }"
        "requirement go needs B.seen = 1"
    )
    layout, count, _ = solved(plant, True)
    assert [dim.variables for dim in layout.dims] == [(0, 1, 2)]
    assert (layout.size, count) == (2, 2)
