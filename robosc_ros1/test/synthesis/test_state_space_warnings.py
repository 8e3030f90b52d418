"""Warnings and errors that only the state space can tell."""

from __future__ import annotations

import pytest
from synthesis.plants import supervisor_of

from robosc.errors import Diagnostic, Severity

SWITCH = """
    component Switch {
        outgoing message flip with type: none
        behaviour {
            initial marked state off { on response from flip goto on }
            marked state on { on response from flip goto off }
        }
    }
"""
MOTOR = """
    datatype object Speed { x: double }
    component Motor {
        incoming message move with identifier: "/vel", type: Speed links link
        incoming message stop with identifier: "vel", type: Speed links link
    }
"""
PROVIDED = "provide move with { x: 1.0 } provide stop with {} "


def told(body: str) -> list[Diagnostic]:
    return [d for d in supervisor_of(body).diagnostics if d.code != "never-allowed"]


def codes(body: str) -> list[str]:
    return [d.code for d in told(body)]


# --- commands on one topic


def test_two_commands_on_one_topic() -> None:
    (found,) = told(SWITCH + MOTOR + PROVIDED + "requirement stop needs Switch.on")
    assert found.code == "topic-conflict"
    assert found.severity is Severity.WARNING
    assert found.message == (
        "move and stop both go to /vel and can be enabled together: after flip.response"
    )
    assert found.span.text == "stop"
    assert found.notes[0].span is not None
    assert found.notes[0].span.text == "move"


def test_commands_that_exclude_each_other() -> None:
    body = "requirement stop needs Switch.on requirement move needs Switch.off"
    assert codes(SWITCH + MOTOR + PROVIDED + body) == []


@pytest.mark.parametrize("order", ["move over stop", "stop over move"])
def test_commands_of_which_one_is_preferred(order: str) -> None:
    body = f"requirement stop needs Switch.on prefer {order}"
    assert codes(SWITCH + MOTOR + PROVIDED + body) == []


def test_commands_that_are_preferred_to_another_one_only() -> None:
    other = "component Lamp { incoming message blink with type: none }"
    body = "requirement stop needs Switch.on prefer { move, stop } over blink"
    assert codes(SWITCH + MOTOR + PROVIDED + other + body) == ["topic-conflict"]


def test_commands_that_only_synthesis_keeps_apart() -> None:
    body = """
        component A {
            incoming message one with identifier: "/t", type: none
            incoming message two with identifier: "/t", type: none
            behaviour {
                initial marked state s { on request to one goto bad on request to two goto s }
                marked state bad {}
            }
        }
        requirement never A.bad
    """
    assert codes(body) == []


# --- provided data


def test_provide_statements_that_hold_together() -> None:
    (found,) = told(
        SWITCH
        + MOTOR.replace("incoming message stop", "incoming message halt").replace('"vel"', '"halt"')
        + "provide move with { x: 1.0 } if Switch.on provide move with { x: 2.0 } if !Switch.off"
        " provide halt with {} provide move with { x: 3.0 }"
    )
    assert found.code == "provide-overlap"
    assert "can hold together: after flip.response" in found.message
    assert found.span.text == "provide move with { x: 2.0 } if !Switch.off"


@pytest.mark.parametrize("condition", ["", " if Switch.on"])
def test_what_stands_behind_provided_data_for_the_rest(condition: str) -> None:
    (found,) = told(
        SWITCH
        + MOTOR.replace('"vel"', '"v"')
        + "provide stop with {} provide move with { x: 1.0 } if Switch.off"
        + f" provide move with {{ x: 2.0 }} provide move with {{ x: 3.0 }}{condition}"
    )
    assert found.code == "provide-overlap"
    assert found.span.text == f"provide move with {{ x: 3.0 }}{condition}"


def test_provide_statements_that_exclude_each_other() -> None:
    body = (
        "provide move with { x: 1.0 } if Switch.on provide move with { x: 2.0 } if Switch.off"
        " requirement stop needs Switch.on requirement move needs Switch.off"
    )
    assert codes(SWITCH + MOTOR + body) == []


def test_command_without_data() -> None:
    found = told(
        SWITCH
        + MOTOR.replace('"vel"', '"v"')
        + "provide move with { x: 1.0 } if Switch.on provide stop with {}"
    )
    assert [d.code for d in found] == ["provide-missing"]
    assert "can be sent where none of its provide conditions holds: at the start" in (
        found[0].message
    )


def test_command_that_no_statement_provides() -> None:
    alone = MOTOR.replace('"vel"', '"v"')
    (found,) = told(SWITCH + alone + "provide stop with {}")
    assert (found.code, found.span.text) == ("provide-missing", "move")
    assert "nothing says what move carries" in found.message
    # What is never sent, what carries nothing, and what the robot is stopped by.
    assert codes(SWITCH + alone + "provide stop with {} requirement move needs false") == [
        "requirement-never-met"
    ]
    assert codes("component A { incoming message ping with type: none }") == []
    assert codes(SWITCH + alone + "provide move with { x: 1.0 } stop with stop") == []
    # Zeros beside a command to the same topic.
    assert codes(SWITCH + MOTOR + "provide move with { x: 1.0 } prefer stop over move") == []


def test_command_that_is_only_sent_where_it_has_data() -> None:
    body = (
        "provide move with { x: 1.0 } if Switch.on requirement move needs Switch.on"
        " provide stop with {}"
    )
    assert codes(SWITCH + MOTOR.replace('"vel"', '"v"') + body) == []


RELAY = (
    "component Relay {{ behaviour {{ initial marked state first {{ transition{guard} goto then }}"
    " marked state then {{ transition goto then }} }} }}"
    "provide move with {{ x: 1.0 }} if Relay.then"
)
"""The controller leaves its first state before it sends any command, if the guard holds."""


def test_no_command_is_sent_before_internal_transitions_are_taken() -> None:
    model = SWITCH + MOTOR.replace('"vel"', '"v"') + "provide stop with {} "
    assert codes(model + RELAY.format(guard="")) == []
    assert codes(model + RELAY.format(guard=" if Switch.on")) == ["provide-missing"]


# --- requirements

GO = " component B { incoming message go with type: none } "


def test_requirement_that_is_always_true() -> None:
    (found,) = told(SWITCH + GO + "requirement go needs Switch.on or Switch.off")
    assert found.code == "requirement-always-true"
    assert found.span.text == "requirement go needs Switch.on or Switch.off"


def test_disabling_requirement_that_is_always_true() -> None:
    assert codes(SWITCH + GO + "requirement Switch.on and Switch.off disables go") == [
        "requirement-always-true"
    ]


@pytest.mark.parametrize(
    "requirement", ["never Switch.on and Switch.off", "always Switch.on or Switch.off"]
)
def test_state_requirement_that_is_always_true(requirement: str) -> None:
    (found,) = told(SWITCH + GO + "requirement " + requirement)
    assert found.code == "requirement-always-true"


def test_requirement_that_can_never_be_met() -> None:
    (found,) = told(SWITCH + GO + "requirement go needs Switch.on and Switch.off")
    assert found.code == "requirement-never-met"
    assert found.message.endswith("can never be met: go can never happen")


def test_requirement_on_a_command_that_a_component_blocks_anyway() -> None:
    body = """
        component A {
            incoming message go with type: none
            behaviour { initial marked state still {} marked state ready { on request to go } }
        }
        requirement go needs Switch.on
    """
    assert codes(SWITCH + body) == []


def test_requirement_that_is_true_wherever_the_plant_can_but_not_everywhere() -> None:
    """It says what the component's synchronisation says too; that is no fault."""
    body = """
        component A {
            incoming message go with type: none
            outgoing message done with type: none
            behaviour {
                initial marked state home { on request to go goto away }
                state away { on response from done goto home }
            }
        }
        requirement go needs A.home
    """
    assert codes(body) == []


def test_requirements_that_are_never_met_together_are_named() -> None:
    """Each of them by itself is met, and the third has nothing to do with it."""
    body = (
        SWITCH
        + SWITCH.replace("Switch", "Lamp").replace("flip", "turn")
        + "component A { incoming message go with type: none }"
        " requirement go needs Lamp.off"
        " requirement Switch.off disables go"
        " requirement go needs Lamp.off => Switch.off"
    )
    (found,) = told(body)
    assert found.code == "requirement-never-met"
    assert found.message == (
        "'requirement go needs Lamp.off', 'requirement Switch.off disables go' and 'requirement go"
        " needs Lamp.off => Switch.off' can never be met together: go can never happen"
    )
    assert [note.message for note in found.notes] == ["together with this one"] * 2
    (found,) = told(body + " requirement go needs Switch.off")
    assert found.message == (
        "'requirement Switch.off disables go' and 'requirement go needs Switch.off' can never be"
        " met together: go can never happen"
    )


def test_requirements_that_wait_for_each_other() -> None:
    """Either would be met if the other command could be sent."""
    parts = [
        f"component {name} {{ incoming message go{name} with type: none behaviour {{"
        f" initial marked state off {{ on request to go{name} goto on }} marked state on {{ }} }} }}"
        f" requirement go{name} needs {other}.on"
        for name, other in ("AB", "BA")
    ]
    assert [d.message for d in told(" ".join(parts))] == [
        "'requirement goA needs B.on' can never be met under control: goA can never happen",
        "'requirement goB needs A.on' can never be met under control: goB can never happen",
    ]


# --- guarded transitions

GUARDED = """
    component A {
        outgoing message m with type: integer(0..3)
        incoming message go with type: none
        behaviour {
            variable x: integer(0..3) = 0
            initial marked state s {
                on response from m if FIRST do x := value
                on response from m if SECOND goto t
            }
            marked state t {}
        }
    }
    requirement go needs A.x = 0
"""


def overlap(first: str, second: str) -> list[Diagnostic]:
    found = told(GUARDED.replace("FIRST", first).replace("SECOND", second))
    return [d for d in found if d.code == "guard-overlap"]


def test_guards_that_overlap_by_value() -> None:
    (found,) = overlap("value < 2", "value = 1")
    assert found.severity is Severity.ERROR
    assert found.message == (
        "the guards 'value < 2' and 'value = 1' of two transitions on m.response in state s of A"
        " can hold together: at the start"
    )
    assert found.span.text.startswith("on response from m if value = 1")


def test_guards_that_overlap_in_a_later_state() -> None:
    (found,) = overlap("A.x < 2 or value = 3", "x >= 2")
    assert "after m.response(2)" in found.message or "after m.response(3)" in found.message


def test_guards_that_exclude_each_other() -> None:
    assert overlap("value < 2", "value >= 2") == []
    assert overlap("x = value", "x != value") == []


def test_guards_that_would_overlap_in_states_never_reached() -> None:
    assert overlap("x > value and x = 0", "x < 0 or x != 0 and value = 3 and x = 9 - 9") == []


def test_transition_of_the_whole_automaton_is_told_once() -> None:
    body = """
        component A {
            outgoing message m with type: integer(0..3)
            behaviour {
                on response from m if value < 2 goto s
                on response from m if value < 3 goto t
                initial marked state s {}
                marked state t {}
            }
        }
    """
    assert codes(body) == ["guard-overlap"]
