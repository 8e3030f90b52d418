"""Messages of which a model asks whether they have ever arrived."""

from __future__ import annotations

import random

import pytest
from emit.generated_code import supervisor_of
from emit.scripted_controllers import faults_of
from emit.test_cif import check
from emit.test_controller_follows_the_plant import Twin, walk_through
from synthesis.oracle import Oracle

from robosc.model.resolve import load
from robosc.plant.model_text import to_dsl
from robosc.source import Source

MODEL = """
robot Watch {
    component Stop {
        outgoing message estop with type: boolean
        outgoing message gps with timeout: 200 ms, type: none
        behaviour {
            variable pressed: boolean
            variable lost: integer(0..2)
            initial marked state on {
                on response from estop do pressed := value
                on timeout from gps do lost := 1
                on response from gps if gps.heard and gps.silent do lost := 2
            }
        }
    }
    component Base {
        incoming message move with type: none
        incoming message warn with type: none
        incoming message wait with type: none
    }
    requirement move needs estop.heard and !Stop.pressed
    requirement warn needs gps.heard and gps.silent
    requirement wait needs !gps.heard or Stop.lost = 2
}
"""


def test_it_is_read_twice_and_exported() -> None:
    robot, _ = load(Source("model.rscd", MODEL))
    assert robot is not None
    check(robot)
    phases = {state for slot in [Oracle(robot)] for state in slot.controlled[0]}
    assert any("unheard" in state for state in phases)
    assert any("silent" in state for state in phases)


def test_guards_say_it_as_models_do() -> None:
    supervisor = supervisor_of(MODEL)
    texts = {g.event.name: to_dsl(g.expr, supervisor.plant.robot) for g in supervisor.guards}
    assert texts["move"] == "estop.heard and !Stop.pressed"
    assert texts["warn"] == "gps.heard and !gps.fresh"
    assert texts["wait"] == "!gps.heard or Stop.lost = 2"


def test_a_message_that_nobody_asks_of_has_no_memory() -> None:
    text = MODEL.replace("estop.heard and ", "")
    robot, _ = load(Source("model.rscd", text))
    assert robot is not None
    assert robot.communications["Stop.estop"].phases is None
    assert robot.communications["Stop.gps"].phases is not None


@pytest.mark.parametrize("seed", range(2))
def test_the_controller_does_what_the_plant_does(seed: int) -> None:
    walk_through(Twin(MODEL), random.Random(seed))


@pytest.mark.slow
def test_the_test_of_the_package_agrees() -> None:
    assert faults_of(supervisor_of(MODEL)) == []
