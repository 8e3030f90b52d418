"""Explanations hold: each trace can happen, and ends where no supervisor may let it end."""

from __future__ import annotations

import random

import pytest
from random_models import random_model
from synthesis.oracle import Event, Occurrence, Oracle, OracleState
from synthesis.oracle_values import OutOfRange
from synthesis.subject import robot_of

from robosc import pipeline
from robosc.language.events import EventKind
from robosc.supervisor import Step

pytestmark = pytest.mark.slow


def event_of(step: Step) -> Event:
    return Event(step.event.kind, step.event.key, step.event.index)


def replay(oracle: Oracle, trace: tuple[Step, ...]) -> OracleState | None:
    """The state after a trace that keeps the requirements; None if its end leaves a range."""
    state = oracle.initial
    for number, step in enumerate(trace, start=1):
        event = event_of(step)
        assert oracle.required(state, event)
        taken = ()
        if event.kind is not EventKind.TAU:
            paths = [parameter.path for parameter in step.event.parameters]
            taken = tuple(zip(paths, step.values, strict=True))
        try:
            state = oracle.step(state, Occurrence(event, taken))
        except OutOfRange:
            assert number == len(trace)
            return None
    return state


def test_explanations_of_random_robots() -> None:
    replayed = 0
    for seed in range(700, 748):
        robot = robot_of(random_model(random.Random(seed), 1 + seed % 2))
        oracle, supervisor = Oracle(robot), pipeline.synthesize(robot)
        explained = {None if e.event is None else event_of(Step(e.event))
                     for e in supervisor.explanations}  # fmt: skip
        assert oracle.empty == (None in explained)
        for event in oracle.events:
            if event.controllable and not oracle.empty and oracle.status(event) != "as required":
                # A cancel that nothing ever asks for is no fault of the model.
                wanted = event.kind is not EventKind.CANCEL or any(
                    event in oracle.possible(state) and oracle.required(state, event)
                    for state in oracle.controlled[0]
                )
                assert event in explained or not wanted, (seed, event)
        for explanation in supervisor.explanations:
            if explanation.trace:
                assert replay(oracle, explanation.trace) not in oracle.kept, (seed, explanation)
                replayed += 1
    assert replayed > 20
