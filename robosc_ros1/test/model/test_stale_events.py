"""Which messages without timeout forbid a command, however the model says so."""

from __future__ import annotations

import pytest
from model_text import faults

from robosc.errors import render_all
from robosc.model.resolve import load
from robosc.source import Source

STOP = """
    component Stop {{
        outgoing message stop with {timeout} type: boolean
        outgoing message reset with type: none
        behaviour {{
            {behaviour}
        }}
    }}
    component Base {{
        incoming message drive with type: none
        incoming message halt with type: none
    }}
    {statements}
"""
STATES = """
    initial marked state running { on response from stop if value goto stopped }
    marked state stopped { on response from reset goto running }
"""
FLAG = """
    variable pressed: boolean
    initial marked state on {
        on response from stop if value do pressed := true
        on response from reset do pressed := false
    }
"""
INTERNAL = """
    variable pressed: boolean
    on response from stop if value do pressed := true
    on response from reset do pressed := false
    initial marked state running { transition if pressed goto stopped }
    marked state stopped { transition if !pressed goto running }
"""


def told(behaviour: str, statements: str, *, timeout: str = "") -> list[str]:
    """The messages of which the warning tells."""
    text = STOP.format(behaviour=behaviour, statements=statements, timeout=timeout)
    return [place for code, place in faults(text) if code == "stale-event"]


@pytest.mark.parametrize(
    ("behaviour", "statements"),
    [
        (STATES, "requirement drive needs Stop.running"),
        (STATES, "requirement Stop.stopped disables drive"),
        (STATES, "requirement drive needs !Stop.stopped"),
        (STATES, "requirement drive needs true and (Stop.running or reset.heard)"),
        (STATES, "condition may = Stop.running requirement drive needs may"),
        (STATES, "condition may = Stop.running for 1 s requirement drive needs may"),
        (FLAG, "requirement drive needs !Stop.pressed"),
        (FLAG, "requirement drive needs Stop.pressed = false"),
        (FLAG, "requirement halt needs Stop.pressed => false"),
        (INTERNAL, "requirement drive needs Stop.running"),
    ],
)
def test_however_the_model_says_it(behaviour: str, statements: str) -> None:
    assert told(behaviour, statements) == ["stop"]


def test_a_command_that_a_behaviour_takes_in_some_states_only() -> None:
    behaviour = STATES.replace("running {", "running { on request to drive", 1)
    assert told(behaviour, "") == ["stop"]


def test_a_state_that_performs_is_left() -> None:
    behaviour = """
        initial marked state driving performs drive then { on response from stop goto stopped }
        marked state stopped { on response from reset goto driving }
    """
    assert told(behaviour, "") == ["stop"]


def test_an_order_leads_from_one_command_to_another() -> None:
    behaviour = """
        initial marked state driving performs drive then { on response from stop goto halting }
        marked state halting performs halt then { on response from reset goto driving }
    """
    assert told(behaviour, "") == []


def test_the_command_of_stop_is_none_that_goes_on() -> None:
    behaviour = """
        initial marked state driving performs drive then { on response from stop goto halting }
        marked state halting performs halt then
    """
    assert told(behaviour, "stop with halt") == ["stop"]
    assert told(STATES, "requirement halt needs Stop.running stop with halt") == []


@pytest.mark.parametrize("behaviour", [STATES, INTERNAL])
def test_what_only_allows_a_command_is_not_told(behaviour: str) -> None:
    """Without the message of the reset the robot does less."""
    assert told(behaviour, "requirement drive needs Stop.stopped") == ["reset"]
    assert told(behaviour, "") == []


def test_a_timeout_answers_it() -> None:
    assert told(STATES, "requirement drive needs Stop.running", timeout="timeout: 1 s,") == []


def test_what_has_been_heard_once_is_no_heartbeat() -> None:
    assert told(STATES, "requirement drive needs Stop.running and stop.heard") == ["stop"]


def test_what_stale_data_tells_is_not_told_again() -> None:
    flag = FLAG.replace("if value do pressed := true", "do pressed := value")
    text = STOP.format(
        behaviour=flag.replace("on response from reset do pressed := false", ""),
        statements="requirement drive needs !Stop.pressed",
        timeout="",
    )  # fmt: skip
    codes = {code for code, _ in faults(text)}
    assert "stale-data" in codes and "stale-event" not in codes


def test_commands_are_named_and_the_remedy_is_an_edit() -> None:
    text = STOP.format(
        behaviour=STATES,
        statements="requirement { drive, halt } needs Stop.running",
        timeout="",
    )  # fmt: skip
    _, diagnostics = load(Source("model.rscd", f"robot R {{ {text} }}"))
    (found,) = (d for d in diagnostics if d.code == "stale-event")
    assert found.message.startswith("drive and halt go on where a message of stop is lost")
    assert "requirement drive needs stop.fresh" in render_all([found])
