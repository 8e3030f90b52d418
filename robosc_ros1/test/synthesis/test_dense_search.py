"""The dense engine where values are many: few sweeps, conditions set by set, paths step by step."""

from __future__ import annotations

import numpy as np
import pytest
import steep_families
from synthesis.plants import plant_of

from robosc.expr.tree import Binary, Expr, Literal, VariableRef
from robosc.expr.types import BooleanType, IntegerType
from robosc.plant.logic import conjunction, disjunction, negation
from robosc.synthesis.compiled_steps import Stepper
from robosc.synthesis.controlled_system import steps_of
from robosc.synthesis.dense import transitions
from robosc.synthesis.dense.bitset import count, places
from robosc.synthesis.dense.dense_engine import DenseEngine, DenseSolution, Progress
from robosc.synthesis.dense.layout import Layout
from robosc.synthesis.dense.search import DenseSystem


def solution_of(text: str, progress: Progress | None = None) -> DenseSolution:
    plant = plant_of(text)
    compiler = transitions.Compiler(plant)
    rules = [compiler.event(event) for event in plant.events]
    return DenseEngine(compiler, rules, Layout.plain(plant), progress).solve()


def test_counters_run_up_and_down_in_a_few_sweeps() -> None:
    sweeps: list[str] = []
    solution_of(steep_families.tanks(70), lambda what, done, most: sweeps.append(what))
    assert 0 < sweeps.count("reachable states") <= 12  # a step at a time they would be 200


def conditions_of(solution: DenseSolution) -> list[Expr]:
    plant = solution.engine.plant
    simple = [condition for condition, _ in plant.invariants]
    simple += [negation(condition) for condition in simple]
    either = disjunction(simple[:2])
    return [*simple, either, negation(either), conjunction([either, disjunction(simple[-2:])])]


@pytest.mark.parametrize("wide", [0, 2**16])
def test_conditions_hold_where_the_steps_say_so(wide: int, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(transitions, "_WIDE", wide)
    solution = solution_of(steep_families.tanks(9))
    engine, stepper = solution.engine, Stepper(solution.engine.plant)
    for condition in conditions_of(solution):
        everywhere = places(engine.layout.everything())
        states = {place: engine.layout.state(int(place)) for place in everywhere}
        expected = [place for place, state in states.items() if stepper.holds(condition, state)]
        found = engine.meeting(engine.layout.everything(), condition)
        assert np.array_equal(places(found), expected)
        within = engine.meeting(solution.states, condition)
        assert count(within) == len(set(expected) & set(places(solution.states)))


def test_paths_are_shortest_and_made_of_steps() -> None:
    system = DenseSystem(solution_of(steep_families.tanks(12)))
    stepper = Stepper(system.plant)
    level = IntegerType((0, 11))
    condition = Binary("=", VariableRef("Tank1", "level", level), Literal(5, level), BooleanType())
    path = system.nearest(condition)
    assert path is not None
    assert len(path) - 1 == 10  # what is in the second tank went through the first
    assert stepper.holds(condition, path[-1]) and path[0] == system.plant.initial
    assert len(steps_of(stepper, path)) == 10
