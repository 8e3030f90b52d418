"""Decisions over data against a second reading that knows nothing of classes.

The oracle takes the numbers and strings themselves, a sample of every class there can be, and finds
the supervisor by exhaustive search. What only compares with constants must come out exactly alike.
"""

from __future__ import annotations

import random
from typing import Any

import pytest
from data_models import SAMPLES, data_model
from synthesis.oracle import Event, Oracle, OracleState

from robosc import pipeline
from robosc.ir.automaton import PlantState, VariableKind
from robosc.model.entities import Robot
from robosc.model.resolve import load
from robosc.model.types import DoubleType, IntegerType, StringType
from robosc.source import Source
from robosc.supervisor import Supervisor
from robosc.synthesis import explore

TYPES = {"double": DoubleType(), "integer": IntegerType(), "string": StringType()}


def robot_of(text: str) -> Robot:
    robot, diagnostics = load(Source("model.rscd", text))
    assert robot is not None, (text, diagnostics)
    return robot


def classified(supervisor: Supervisor, oracle: Oracle, state: OracleState) -> PlantState:
    """The state of the plant that a state of the oracle belongs to."""
    kinds = {"at": VariableKind.LOCATION, "var": VariableKind.DATA, "phase": VariableKind.PHASE}
    found = {
        (kinds[what], name): value for (what, name), value in zip(oracle.slots, state, strict=True)
    }
    return tuple(v.values.index(found[v.kind, v.name]) for v in supervisor.plant.variables)


def differences(text: str, engine: str) -> list[Any]:
    robot = robot_of(text)
    oracle = Oracle(robot, {TYPES[name]: values for name, values in SAMPLES.items()})
    supervisor = pipeline.synthesize(robot, engine)
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
                ours_allow = oracle.holds(guard.expr, state)
                if ours_allow != (event in oracle.enabled(state)):
                    found.append((event, state, ours_allow))
                    break
        if guard.status != oracle.status(event):
            found.append((event, guard.status, oracle.status(event)))
    return found


@pytest.mark.parametrize("seed", range(25))
def test_comparisons_with_constants_are_exact(seed: int) -> None:
    text = data_model(random.Random(seed))
    for engine in ("dense", "bdd"):
        assert not differences(text, engine), text
