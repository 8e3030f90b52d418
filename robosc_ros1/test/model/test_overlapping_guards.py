"""Guards that can hold together, told although there is no state space to look into."""

from __future__ import annotations

import pytest
from model_text import faults

from robosc.errors import Diagnostic
from robosc.model.resolve import load
from robosc.model.ros.definitions import MessageDefinitions
from robosc.source import Source

COMPONENT = """
    component A {
        outgoing message level with type: integer(0..3)
        outgoing message speed with type: double
        outgoing message word with type: string
        outgoing message list with type: Seen links seen
        behaviour {
            variable x: integer(0..18446744073709551615)
            variable small: integer(-1..1)
            variable b: boolean
            variable c: Colour
            initial marked state s {
                on response from EVENT if FIRST do small := 0, b := true, x := 3 goto t
                on response from EVENT if SECOND goto s
            }
            marked state t { }
        }
    }
    datatype object Seen { list: array(boolean) }
    datatype enum Colour from integer to { value = 1 -> red default -> blue }
    interface seen use Seen from somewhere
"""
OVERLAPPING = [
    ("level", "value < 2", "value = 1"),
    ("level", "b", "b"),
    ("level", "b", "s"),
    ("level", "small = value", "value = 0"),
    ("level", "c = red", "b"),
    ("list", "value.list[0]", "value.list[1]"),
    ("level", "count(x for x in [b, s]) > 1", "b"),
    ("level", "x = 1", "x > 0"),
    ("level", "x > 18446744073709551613", "x < 18446744073709551615"),
    ("speed", "value > 0.5", "value < 0.6"),
    ("speed", "value = 0.5", "value <= 0.5"),
    ("speed", "value != 0.5", "value != 0.7"),
    ("speed", "!(value > 0.5)", "!(value <= 0.5)"),  # not a number is neither
    ("word", "value != 'go'", "value != 'stop'"),
]
EXCLUDING = [
    ("level", "value < 2", "value >= 2"),
    ("level", "small = value", "small != value"),
    ("level", "small = value", "value = 3"),
    ("level", "x = small", "x = 3 and small < 0"),  # too many values: left to the state space
    ("speed", "value > 0.5", "value <= 0.5"),
    ("speed", "value < 1", "isnan(value)"),  # it is not only compared: left to the state space
    ("speed", "value > 0.5 and value < 0.7", "value < 0.5 or value > 0.7"),
    ("speed", "value * 2.0 > 0.5", "value > 0.1"),  # neither
    ("word", "value = 'go'", "value = 'stop'"),
    ("level", "x > 18446744073709551613", "x < 18446744073709551614"),
    ("level", "s and b", "t"),
    ("level", "c = red", "c = blue"),
    ("list", "value.list[0]", "!value.list[0]"),
]


def overlaps(event: str, first: str, second: str, rest: str) -> list[tuple[str, str]]:
    text = COMPONENT.replace("EVENT", event).replace("FIRST", first).replace("SECOND", second)
    return [f for f in faults(text + rest) if f[0] == "guard-overlap"]


@pytest.mark.parametrize(("event", "first", "second"), OVERLAPPING)
def test_guards_that_can_hold_together_are_told_beside_other_errors(
    event: str, first: str, second: str
) -> None:
    ((_, marked),) = overlaps(event, first, second, "requirement always A.other")
    assert marked.startswith(f"on response from {event} if {second}")
    assert overlaps(event, first, second, "") == [], "else the state space tells"


@pytest.mark.parametrize(("event", "first", "second"), EXCLUDING)
def test_guards_that_exclude_each_other(event: str, first: str, second: str) -> None:
    assert overlaps(event, first, second, "requirement always A.other") == []


def in_library(first: str, second: str) -> list[Diagnostic]:
    text = COMPONENT.replace("EVENT", "level").replace("FIRST", first).replace("SECOND", second)
    source = Source("Lib.rscd", f"library Lib {{ {text} }}")
    return [
        d for d in load(source, definitions=MessageDefinitions())[1] if d.code == "guard-overlap"
    ]


def test_in_a_library_what_comes_in_decides() -> None:
    (found,) = in_library("value < 2", "value =  1")
    assert found.message == (
        "the guards 'value < 2' and 'value = 1' of two transitions on level.response of A can hold"
        " together"
    )
    assert in_library("value < 2", "value = 1 and b") == [], "b may never be true"
    assert in_library("b", "b") == []


def test_freshness_tells_guards_apart() -> None:
    """A phase counts as part of the state: in a library nothing is told of what reads it."""
    text = """%s L { component C {
        outgoing message a with timeout: 1 s, type: %s
        behaviour { initial marked state s {
            on response from a if a.fresh goto s
            on response from a if %sa.fresh goto s
        } }
    } }"""
    for word, type_, operator, told in [
        ("library", "double", "!", False),
        ("library", "double", "", False),
        ("robot", "unknown", "!", False),
        ("robot", "unknown", "", True),
    ]:
        _, diagnostics = load(Source("l.rscd", text % (word, type_, operator)))
        assert any(d.code == "guard-overlap" for d in diagnostics) is told
