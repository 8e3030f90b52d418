"""A machine that goes on from a state as it is told allows what the machine that told it does."""

from __future__ import annotations

import json
import random

import pytest
from ros_support import EXAMPLES

from robosc import pipeline
from robosc.simulate.machines.execute import Execution
from robosc.simulate.script.documents import command_document, state_document
from robosc.simulate.start import machine_maker


@pytest.mark.parametrize("model", ["line_follower", "order", "patrol", "door"])
def test_a_restored_state_is_the_one_that_was_told(model: str) -> None:
    robot = pipeline.load(EXAMPLES / model / f"{model}.rscd").robot
    make = machine_maker(pipeline.supervise(robot), execute=True)
    machine, rng = make({}), random.Random(5)
    assert isinstance(machine, Execution)
    for _ in range(20):
        step = machine.draw(rng)
        assert step is not None
        if isinstance(step, float):
            machine.wait(step)
        else:
            machine.fire(*step)
        told = json.loads(json.dumps(state_document(machine)))
        twin = make({})
        assert isinstance(twin, Execution)
        assert twin.restore(told) == []
        for name in ("components", "variables", "communications"):
            assert state_document(twin)[name] == state_document(machine)[name]
        commands, again = (
            [{**command_document(c), "count": 0} for c in m.commands()] for m in (machine, twin)
        )
        assert commands == again
