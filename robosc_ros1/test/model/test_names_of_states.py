"""States in states and the stages of performing ones in conditions: by path, or the end of one."""

from __future__ import annotations

import pytest
from model_text import resolve
from nested_models import PARTS

from robosc.errors import render_all
from robosc.model.resolve import load
from robosc.plant.model_text import to_dsl
from robosc.source import Source

MISSION = """
initial marked state idle { on response from near goto work }
state work {
    initial state legs {
        initial state driving performs go then goto blinking {
            retry 2 times every 1 s else goto idle
        }
        state blinking performs ring then goto plain
    }
    state plain performs go then goto idle
}
"""
ROBOT = PARTS % MISSION + " component Bell { incoming message ring with type: none }"


@pytest.mark.parametrize(
    ("condition", "meant"),
    [
        ("P.driving", "P.work.legs.driving"),
        ("P.legs.driving", "P.work.legs.driving"),
        ("P.driving.performing", "P.work.legs.driving.performing"),
        ("P.legs.driving.waiting", "P.work.legs.driving.waiting"),
        ("P.work.legs.driving.due", "P.work.legs.driving.due"),
        ("P.driving.retries = 1", "P.work.legs.driving.retries = 1"),
    ],
)
def test_the_end_of_a_path_will_do(condition: str, meant: str) -> None:
    robot = resolve(ROBOT + f"requirement ring needs {condition}")
    assert to_dsl(robot.requirements[0].condition, robot) == meant
    inside = MISSION.replace(
        "goto plain", f"goto plain {{ after 1 s if {condition[2:]} goto idle }}"
    )
    resolve(ROBOT.replace(MISSION, inside))


@pytest.mark.parametrize(
    ("condition", "place", "message", "hint"),
    [
        ("P.wrk.driving", "wrk", "P has no variable or state 'wrk'", "did you mean 'work'?"),
        ("P.work.drving", "drving", "no state 'drving' stands in state 'P.work'", "legs, plain"),
        ("P.work.driving", "driving", "no state 'driving' stands in", "mean 'legs.driving'?"),
        ("P.idle.due", "due", "no state stands in state 'P.idle'", ""),
        ("P.driving.begun", "begun", "'P.work.legs.driving' has no stage 'begun'", "waiting"),
        ("P.plain.waiting", "waiting", "does not wait before it tries again", "retry every"),
        ("P.plain.retries = 1", "retries", "of state 'P.work.plain' are not counted", "2 times"),
        ("P.blinking.performing", "performing", "is done when its command is sent", ""),
    ],
)
def test_what_is_no_part_of_a_state_is_told(
    condition: str, place: str, message: str, hint: str
) -> None:
    text = f"robot Test {{ {ROBOT} requirement ring needs {condition} }}"
    robot, diagnostics = load(Source("model.rscd", text))
    assert robot is None
    (fault,) = (d for d in diagnostics if d.code == "unknown-member")
    assert fault.span.text == place, render_all(diagnostics)
    assert message in fault.message and hint in str(fault.hint or "")


def test_of_a_component_that_is_not_found_nothing_more_is_told() -> None:
    text = """robot Test {
        component Left from Nowhere import Dock
        component Lamp { incoming message lamp with type: none }
        requirement lamp needs Left.away.leaving.waiting or Left.leaving.retries = 2
        requirement possible Left.away.out from Left.stuck
    }"""
    _, diagnostics = load(Source("model.rscd", text))
    assert [d.code for d in diagnostics] == ["library-not-found"], render_all(diagnostics)
