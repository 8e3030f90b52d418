"""Generated code of random missions, on numbers themselves, held against what the plant allows."""

from __future__ import annotations

import math
import random
import re

import pytest
from emit.steps_of_controllers import Run, step
from quick import quick_first
from synthesis.test_missions_differential import mission

from robosc.errors import Severity
from robosc.language.events import EventKind
from robosc.model.resolve import load
from robosc.plant.build import lower
from robosc.plant.step import holds
from robosc.source import Source
from robosc.supervisor import Supervisor
from robosc.synthesis import synthesize

NUMBERS = [0.0, 0.5, math.nextafter(0.5, 1.0), 1.0, math.inf, math.nan]


def with_numbers(text: str) -> str:
    """The mission with numbers without bounds in place of booleans and counters."""
    text = text.replace("near with type: boolean", "near with type: double")
    text = text.replace("request: none, response: boolean", "request: none, response: double")
    text = text.replace("variable last: boolean", "variable last: double")
    text = text.replace("variable tries: integer(0..2)", "variable tries: integer")
    text = re.sub(r"last := (true|false)", lambda m: f"last := {int(m[1] == 'true')}.0", text)
    text = re.sub(r"(?<!:= )\bvalue\b", "(value > 0.5)", text)
    return re.sub(r"(?:\bP\.)?\blast\b(?! :=|:)", lambda m: f"({m[0]} > 0.5)", text)


def first_supervisor(seeds: range) -> Supervisor:
    """That of the first of these missions that has one."""
    for seed in seeds:
        robot, diagnostics = load(Source("model.rscd", with_numbers(mission(seed)[0])))
        errors = {d.code for d in diagnostics if d.severity is Severity.ERROR}
        assert errors <= {"no-marked-reachable"}, diagnostics
        if robot is not None:
            supervisor = synthesize(lower(robot))
            if not supervisor.empty:
                return supervisor
    raise AssertionError("none of these missions has a supervisor")


@pytest.mark.parametrize("seed", quick_first(range(30), 12))
def test_steps_of_missions_are_steps_of_the_plant(seed: int) -> None:
    rng = random.Random(seed)
    run = Run(first_supervisor(range(100 * seed, 100 * seed + 100)))
    assert run.state() in set(run.plant.initial_states)
    for _ in range(1000):
        event = rng.choice(run.plant.events)
        carries = event.kind is EventKind.RESPONSE and event.name in (
            "near",
            "go",
            "far",
            "ask",
            "other",
        )
        step(run, event, rng.choice(NUMBERS) if carries else None)
        for condition, _ in run.plant.invariants:
            assert holds(run.plant, condition, run.state())
