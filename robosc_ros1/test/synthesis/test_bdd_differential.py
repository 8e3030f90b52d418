"""The symbolic engine against the explicit one and the oracle, on random robots."""

from __future__ import annotations

import random

import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from random_models import models, random_model
from synthesis.differential import differences
from synthesis.oracle import Oracle
from synthesis.plants import plant_of, replay
from synthesis.same_solutions import assert_same
from synthesis.subject import robot_of

from robosc.expr.tree import Expr
from robosc.language.events import EventKind
from robosc.plant.automaton import Plant
from robosc.plant.logic import conjunction, negation
from robosc.plant.step import Verdict, holds
from robosc.synthesis import synthesize
from robosc.synthesis.bdd.search import SymbolicSystem
from robosc.synthesis.bdd.symbolic_engine import SymbolicEngine
from robosc.synthesis.bdd.synthesize import synthesize_bdd
from robosc.synthesis.compiled_steps import Stepper
from robosc.synthesis.controlled_system import allowed, possible, steps_of

pytest.importorskip("oxidd", reason="the symbolic engine needs the Python package oxidd")

pytestmark = pytest.mark.slow

SMALL = 2**25
relaxed = settings(
    max_examples=50,
    suppress_health_check=list(HealthCheck),
)


def conditions(plant: Plant) -> list[Expr]:
    """Questions about states, as explanations and warnings ask them."""
    found = [possible(plant, event) for event in plant.events if event.controllable]
    found += [allowed(plant, event) for event in plant.events if event.requirement is not None]
    found += [negation(condition) for condition in found]
    return [*found, conjunction(found[:2])]


@relaxed
@given(text=models(st.integers(1, 3)))
def test_the_same_supervisor_as_the_explicit_engine(text: str) -> None:
    plant = plant_of(text)
    explicit = synthesize(plant, "explicit")
    symbolic = synthesize_bdd(plant, memory=SMALL).explained()
    assert symbolic.engine == "bdd"
    for name in ("empty", "plant_states", "controlled_states", "controlled_transitions"):
        assert getattr(symbolic, name) == getattr(explicit, name), name
    assert symbolic.guards == explicit.guards
    told = [(e.event, len(e.trace)) for e in symbolic.explanations]
    assert told == [(e.event, len(e.trace)) for e in explicit.explanations]


@relaxed
@given(text=models(st.integers(1, 2)))
def test_the_oracle_agrees(text: str) -> None:
    robot = robot_of(text)
    assert differences(robot, Oracle(robot), "bdd") == []


@pytest.mark.parametrize("most_disjuncts", [1, 2, 1000])
def test_constants_and_relations_mean_the_same(most_disjuncts: int) -> None:
    for seed in range(24):
        plant = plant_of(random_model(random.Random(seed), 1 + seed % 3))
        expected = SymbolicEngine(plant, memory=SMALL).solve()
        found = SymbolicEngine(plant, memory=SMALL, most_disjuncts=most_disjuncts).solve()
        assert found.empty == expected.empty
        if not found.empty:
            assert_same(expected, found)


@pytest.mark.parametrize("most_nodes", [0, 30, 10**9])
def test_paths_are_of_the_controlled_system(most_nodes: int) -> None:
    """Breadth first or through the fixpoint's sets: each path starts and ends as it should."""
    lengths = 0
    for seed in range(40):
        plant = plant_of(random_model(random.Random(seed), 1 + seed % 3))
        solution = SymbolicEngine(plant, memory=SMALL).solve()
        if solution.empty:
            continue
        guards = synthesize_bdd(plant, memory=SMALL).guards
        system = SymbolicSystem(solution, guards, most_nodes)
        shortest = SymbolicSystem(solution, guards)
        for condition in conditions(plant):
            path = system.nearest(condition)
            best = shortest.nearest(condition)
            assert (path is None) == (best is None)
            if path is None or best is None:
                continue
            assert path[0] == plant.initial
            assert holds(plant, condition, path[-1])
            assert all(system.is_good(state) for state in path)
            steps = steps_of(Stepper(plant), path)
            assert replay(plant, steps) == path[-1]
            assert len(path) >= len(best)
            lengths += len(path)
    assert lengths > 100


def test_explanations_end_where_they_say() -> None:
    seen = 0
    for seed in range(60):
        plant = plant_of(random_model(random.Random(seed), 1 + seed % 3))
        for explanation in synthesize_bdd(plant, memory=SMALL).explained().explanations:
            if explanation.trace and explanation.event is not None:
                seen += 1
                end = replay(plant, explanation.trace)
                assert isinstance(end, Verdict | tuple)
                assert any(
                    step.event is explanation.event
                    or (step.event.kind is EventKind.TAU and step.event == explanation.event)
                    for step in explanation.trace
                )
    assert seen > 5
