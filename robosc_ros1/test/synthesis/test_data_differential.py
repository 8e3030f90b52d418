"""Decisions over data against a second reading that knows nothing of classes.

The oracle takes the numbers and strings themselves, a sample of every class there can be, and finds
the supervisor by exhaustive search. What only compares with constants must come out exactly alike.
"""

from __future__ import annotations

import math
import random
from functools import lru_cache
from typing import Any

import pytest
from data_models import SAMPLES, data_model
from quick import quick_first
from synthesis.oracle import Event, Oracle, OracleState

from robosc import pipeline
from robosc.expr.types import ArrayType, DoubleType, IntegerType, StringType
from robosc.model.entities import Robot
from robosc.model.resolve import load
from robosc.plant.automaton import Plant, PlantState, VariableKind
from robosc.plant.build import lower
from robosc.plant.logic import exact
from robosc.plant.step import holds
from robosc.source import Source
from robosc.supervisor import Supervisor
from robosc.synthesis import explore, synthesize
from robosc.synthesis.event_parameters import weight
from robosc.synthesis.verify.verification import verify

TYPES = {"double": DoubleType(), "integer": IntegerType(), "string": StringType()}


def robot_of(text: str) -> Robot:
    robot, diagnostics = load(Source("model.rscd", text))
    assert robot is not None, (text, diagnostics)
    return robot


def classified(supervisor: Supervisor, oracle: Oracle, state: OracleState) -> PlantState:
    """The state of the plant that a state of the oracle belongs to."""
    kinds = {
        "at": VariableKind.LOCATION,
        "var": VariableKind.DATA,
        "phase": VariableKind.PHASE,
        "parameter": VariableKind.TEST,
    }
    found = {
        (kinds[what], name): value for (what, name), value in zip(oracle.slots, state, strict=True)
    }
    return tuple(v.values.index(found[v.kind, v.name]) for v in supervisor.plant.variables)


@lru_cache(maxsize=2)
def oracle_of(text: str) -> Oracle:
    return Oracle(robot_of(text), {TYPES[name]: values for name, values in SAMPLES.items()})


def differences(text: str, engine: str) -> list[Any]:
    oracle = oracle_of(text)
    supervisor = pipeline.synthesize(oracle.robot, engine)
    states, _ = oracle.controlled
    if supervisor.empty or oracle.empty:
        return [] if supervisor.empty == oracle.empty else ["one is empty"]
    found: list[Any] = []
    ours = set(explore(supervisor).states)
    theirs = {classified(supervisor, oracle, state) for state in states}
    if ours != theirs:
        found.append(f"states: {len(ours)}, oracle {len(theirs)}")
    if supervisor.controlled_states != len(theirs):
        found.append(f"counted: {supervisor.controlled_states}, oracle {len(theirs)}")
    plants = {classified(supervisor, oracle, state) for state in oracle.plant[0]}
    if supervisor.plant_states != len(plants):
        found.append(f"plant: {supervisor.plant_states}, oracle {len(plants)}")
    for guard in supervisor.guards:
        event = Event(guard.event.kind, guard.event.key, guard.event.index)
        for state in states:
            if event in oracle.possible(state):
                ours_allow = oracle.holds(exact(guard.expr), state)
                if ours_allow != (event in oracle.enabled(state)):
                    found.append((event, state, ours_allow))
                    break
        if guard.status != oracle.status(event):
            found.append((event, guard.status, oracle.status(event)))
    return found


CASES = [(seed, "") for seed in range(12)]
CASES += [(seed, "parameter") for seed in range(6)]
CASES += [(seed, extra) for extra in ("failure", "enum") for seed in range(4)]
"""Seeds of random models, and what they have besides."""


@pytest.mark.slow
@pytest.mark.parametrize(("seed", "extra"), CASES)
def test_comparisons_with_constants_are_exact(seed: int, extra: str) -> None:
    text = data_model(random.Random(seed), extra=extra)
    for engine in ("explicit", "bdd"):
        assert not differences(text, engine), text


ARRAYS = {
    "double": [(), (0.3,), (math.nan,), (0.1, 1e308), (-2.5, 0.5, 0.0)],
    "integer": [(), (0,), (2, 3), (-1, 2**53 + 1, 3)],
    "string": [(), ("a",), ("b", "")],
}


@pytest.mark.parametrize("seed", range(16))
def test_what_goes_through_arrays_keeps_the_requirements(seed: int) -> None:
    """The plant takes it as free: that is more than can happen, and never less."""
    rng = random.Random(seed)
    robot = robot_of(data_model(rng, extra="array"))
    supervisor = pipeline.synthesize(robot)
    if supervisor.empty:
        return
    name = str(robot.communications["Sensor.sense"].response)
    samples = {TYPES[name]: SAMPLES[name], ArrayType(TYPES[name]): ARRAYS[name]}
    oracle = Oracle(robot, samples)
    guards = {
        Event(g.event.kind, g.event.key, g.event.index): exact(g.expr) for g in supervisor.guards
    }
    for _ in range(20):
        state = rng.choice(oracle.initials)
        for _ in range(20):
            assert not oracle.unsafe(state)
            allowed = [
                (occurrence, target)
                for occurrence, target in oracle.successors(state)
                if occurrence.event not in guards or oracle.holds(guards[occurrence.event], state)
            ]
            assert all(oracle.required(state, occurrence.event) for occurrence, _ in allowed)
            _, state = rng.choice(allowed)


# --- tests that are taken as free ----------------------------------------------------------------


class Search:
    """The supervisor of a plant by going through all of its states, again and again."""

    def __init__(self, plant: Plant) -> None:
        self.plant = plant
        graph = explore(plant)
        self.states = graph.states
        self.starts = set(range(graph.starts))
        self.targets: dict[tuple[int, int], set[int]] = {}
        for t in graph.transitions:
            self.targets.setdefault((t.source, t.event), set()).add(t.target)
        self.kept = {
            number
            for number, state in enumerate(self.states)
            if all(holds(plant, condition, state) for condition, _ in plant.invariants)
        }
        while (kept := self._smaller()) != self.kept:
            self.kept = kept

    def allowed(self, state: int, event: int) -> bool:
        """Whether a command may be given: required, and good whatever comes of it."""
        requirement = self.plant.events[event].requirement
        if requirement is not None and not holds(self.plant, requirement, self.states[state]):
            return False
        return self.targets[state, event] <= self.kept

    def moves(self) -> list[tuple[int, set[int]]]:
        """From where to where the kept states lead, under control."""
        return [
            (state, targets)
            for (state, event), targets in self.targets.items()
            if state in self.kept
            and (not self.plant.events[event].controllable or self.allowed(state, event))
        ]

    def _smaller(self) -> set[int]:
        moves = self.moves()
        leaving = {state for state, targets in moves if not targets <= self.kept}
        reaching = {n for n in self.kept if self.plant.is_marked(self.states[n])}
        while more := {s for s, t in moves if t & reaching and s not in reaching}:
            reaching |= more
        return (self.kept & reaching) - leaving

    def reached(self) -> set[int]:
        moves = self.moves()
        found = self.starts
        while more := {t for s, targets in moves if s in found for t in targets} - found:
            found = found | more
        return found


@pytest.mark.parametrize(("seed", "extra"), quick_first(CASES, 8))
def test_free_outcomes_are_the_choice_of_the_environment(seed: int, extra: str) -> None:
    rng = random.Random(seed)
    plant = lower(robot_of(data_model(rng, computed=True, extra=extra)))
    while any(weight(event) > 300 for event in plant.events):
        plant = lower(robot_of(data_model(rng, computed=True, extra=extra)))
    search = Search(plant)
    for engine in ("explicit", "bdd"):
        supervisor = synthesize(plant, engine)
        assert supervisor.empty == (not search.starts <= search.kept)
        if supervisor.empty:
            continue
        reached = search.reached()
        assert supervisor.controlled_states == len(reached)
        guards = {id(guard.event): guard.expr for guard in supervisor.guards}
        for state, event in search.targets:
            if state in reached and plant.events[event].controllable:
                ours = holds(plant, guards[id(plant.events[event])], search.states[state])
                assert ours == search.allowed(state, event)
    assert supervisor.empty or verify(supervisor).verified
