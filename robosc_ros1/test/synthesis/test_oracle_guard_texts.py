"""The guards of ``synthesize --json`` are expressions of the language: they can be read again.

A guard that speaks of a phase (``grab.busy``) cannot, since users have no word for that.
"""

from __future__ import annotations

import random

import pytest
from random_models import random_model
from synthesis.oracle import Event, Oracle
from synthesis.subject import robot_of

from robosc import pipeline
from robosc.expr.traversal import walk
from robosc.expr.tree import PhaseRef
from robosc.synthesis.documents import synthesize_document

pytestmark = pytest.mark.slow


def test_guards_read_again_mean_the_same() -> None:
    read = 0
    for seed in range(200, 236):
        text = random_model(random.Random(seed), 1 + seed % 2)
        robot = robot_of(text)
        oracle, supervisor = Oracle(robot), pipeline.synthesize(robot)
        if oracle.empty:
            continue
        document = synthesize_document(supervisor)
        for guard, told in zip(supervisor.guards, document["guards"], strict=True):
            if any(isinstance(part, PhaseRef) for part in walk(guard.expr)):
                continue
            always = f"requirement always {told['guard']}"
            again = robot_of(text.rstrip().removesuffix("}") + always + "}")
            condition = again.requirements[-1].condition
            event = Event(guard.event.kind, guard.event.key, guard.event.index)
            for state in oracle.controlled[0]:
                if event in oracle.possible(state):
                    assert oracle.holds(condition, state) == (event in oracle.enabled(state)), (
                        f"seed {seed}: {told}"
                    )
            read += 1
    assert read > 100
