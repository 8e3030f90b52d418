"""Fixpoints by saturation are those of the plainest iteration, with little memory as well."""

from __future__ import annotations

import random
import sys
from collections.abc import Callable

import pytest
import steep_families
from random_models import random_model
from synthesis.differential import differences
from synthesis.oracle import Oracle
from synthesis.plants import plant_of
from synthesis.subject import robot_of

from robosc.synthesis.bdd import saturation, symbolic_engine
from robosc.synthesis.bdd.manager import Bdd, Manager
from robosc.synthesis.bdd.relations import Disjunct
from robosc.synthesis.bdd.saturation import saturated
from robosc.synthesis.bdd.symbolic_engine import SymbolicEngine

Step = Callable[[Disjunct, Bdd], Bdd]


def iterated(engine: SymbolicEngine, states: Bdd, within: Bdd, step: Step) -> Bdd:
    """The least fixpoint: all steps at once, again and again."""
    while True:
        before = states
        for event in engine.events:
            for disjunct in event.disjuncts:
                states = states | (step(disjunct, before) & within)
        if states == before:
            return states


@pytest.mark.parametrize("seed", range(40))
def test_fixpoints_are_those_of_iteration(seed: int) -> None:
    """Forwards and backwards, from any set and inside any set."""
    chance = random.Random(seed)
    engine = SymbolicEngine(plant_of(random_model(chance, 1 + seed % 3)))
    manager, disjuncts = engine.manager, [event.disjuncts for event in engine.events]
    sets = [engine.encoding.initial, engine.encoding.marked, engine.unsafe(), manager.true]
    sets += [event.possible for event in engine.events]
    for step in (engine.relations.image, engine.relations.preimage):
        for _ in range(5):
            states, within = chance.choice(sets), chance.choice([*sets, ~chance.choice(sets)])
            found = saturated(manager, states, within, disjuncts, step, lambda part, level: None)
            assert found == iterated(engine, states, within, step)


@pytest.mark.slow
def test_what_is_known_may_be_given_up_at_any_time(monkeypatch: pytest.MonkeyPatch) -> None:
    """As where the nodes are used up: whenever there are more than none."""
    monkeypatch.setattr(Manager, "nodes", property(lambda manager: manager.capacity))
    for seed in range(400, 406):
        robot = robot_of(random_model(random.Random(seed), 1 + seed % 2))
        assert differences(robot, Oracle(robot), "bdd") == [], seed
    robot = robot_of(steep_families.crew(5))
    assert differences(robot, Oracle(robot), "bdd") == []


@pytest.mark.slow
def test_few_fixpoints_of_parts_are_enough(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(saturation, "_MOST_KNOWN", 0)
    for seed in range(412, 416):
        robot = robot_of(random_model(random.Random(seed), 1 + seed % 2))
        assert differences(robot, Oracle(robot), "bdd") == [], seed


DEPTH = 300
"""More than the tests themselves need."""


def test_more_variables_than_python_can_recurse() -> None:
    """A set with a level for each of very many variables."""
    count = 2 * DEPTH
    components = "".join(
        f"component C{i} {{ outgoing message m{i} with type: none behaviour {{"
        f" initial marked state a {{ on response from m{i} goto b }}"
        f" marked state b {{ on response from m{i} goto a }} }} }}\n"
        for i in range(count)
    )
    engine = SymbolicEngine(plant_of(f"robot R {{ {components} }}"))
    limit = sys.getrecursionlimit()
    sys.setrecursionlimit(DEPTH)
    try:
        solution = engine.solve()
    finally:
        sys.setrecursionlimit(limit)
    assert solution.controlled_states == 2**count


def test_progress_is_told_by_states_found(monkeypatch: pytest.MonkeyPatch) -> None:
    """Each count is that of a part, and none is more than there are in the end."""
    monkeypatch.setattr(symbolic_engine, "_SECONDS", 0.0)
    told: list[tuple[str, int, int]] = []
    engine = SymbolicEngine(
        plant_of(steep_families.chain(12)), lambda what, done, most: told.append((what, done, most))
    )
    solution = engine.solve()
    reached = [done for what, done, _ in told if what == "reachable states"]
    assert 1 < min(reached) < max(reached) == solution.plant_states
    assert {most for _, _, most in told} == {engine.encoding.most}
