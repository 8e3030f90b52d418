"""Internal transitions that assign, and ``else`` among them."""

from __future__ import annotations

import pytest
from emit.generated_code import supervisor_of
from model_text import faults
from simulate.players import play, session

from robosc.errors import StateSpaceError
from robosc.model.resolve import load
from robosc.plant.build import lower
from robosc.simulate.script.session import Session
from robosc.source import Source

WHEEL = """
    component Wheel {
        outgoing message pulse with type: boolean
        outgoing message level with type: double
        incoming message go with type: none
        behaviour {
            variable turns: integer(0..3)
            variable seen: boolean
            variable last: double
            on response from pulse do seen := value
            on response from level do last := value
            initial marked state idle { %s }
            marked state full { on request to go goto idle }
        }
    }
    requirement go needs Wheel.turns = 0
"""
COUNTING = """
    transition if seen and turns < 3 do seen := false, turns := turns + 1
    transition if seen do turns := 0, seen := false goto full
    transition else do turns := turns + 0
"""


def state_after(player: Session, line: str) -> tuple[str, object, object]:
    """The state of the wheel and its deciding variables after an event."""
    play(player, line)
    state = player.machine.state
    return state.components["Wheel"], state.variables["Wheel.turns"], state.variables["Wheel.seen"]


def test_they_are_taken_until_they_change_nothing() -> None:
    player = session(supervisor_of("robot Rover {" + WHEEL % COUNTING + "}"), execute=True)
    for turns in (1, 2, 3):
        assert state_after(player, "pulse true") == ("idle", turns, False)
    assert state_after(player, "pulse true") == ("idle", 0, False)  # by 'go', which it enabled


def test_one_that_would_leave_a_range_is_not_taken() -> None:
    taus = "transition if seen do turns := turns + 2, seen := false"
    player = session(supervisor_of("robot Rover {" + WHEEL % taus + "}"), execute=True)
    assert state_after(player, "pulse true") == ("idle", 2, False)
    assert state_after(player, "pulse true") == ("idle", 2, True)


def test_an_assigned_variable_decides_if_the_state_may_stay() -> None:
    robot, _ = load(Source("model.rscd", "robot Rover {" + WHEEL % COUNTING + "}"))
    assert robot is not None
    assert {key for key, variable in robot.variables.items() if variable.in_state} == {
        "Wheel.turns",
        "Wheel.seen",
    }


@pytest.mark.parametrize(
    ("taus", "code"),
    [
        ("transition if seen do last := 1.5", "not-finite"),
        ("transition if seen do last := 1.5 goto idle", "not-finite"),
        ("transition else goto full", "misplaced-else"),
        ("transition goto full transition else do turns := 0", "misplaced-else"),
        (
            "transition if seen goto full transition else do turns := 0 transition do turns := 1",
            "misplaced-else",
        ),
    ],
)
def test_faults(taus: str, code: str) -> None:
    found = [c for c, _ in faults(WHEEL % taus) if c in ("not-finite", "misplaced-else")]
    assert found == [code]


def test_an_open_outcome_is_refused() -> None:
    taus = "transition if seen and last > 1.0 do last := last + 1.0 goto full"
    robot, diagnostics = load(Source("model.rscd", "robot Rover {" + WHEEL % taus + "}"))
    assert robot is not None, diagnostics
    with pytest.raises(StateSpaceError, match=r"model\.rscd:\d+: the outcome"):
        lower(robot)


def test_else_hides_where_the_transitions_before_it_do_not() -> None:
    text = """
    interface dock use Dock from nowhere_msgs
    datatype object Result { code: integer }
    component Base {
        action dock with request: none, response: Result, feedback: none links dock
        behaviour {
            on error from dock goto lost
            initial marked state calm { on error from dock if value.code = 3 goto calm %s }
            marked state lost {}
        }
    }
    """
    for rest, expected in (("", []), ("on error from dock else goto calm", ["hidden-transition"])):
        found = [code for code, _ in faults(text % rest) if code == "hidden-transition"]
        assert found == expected
