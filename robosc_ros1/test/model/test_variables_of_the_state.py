"""Which variables synthesis has to know, and that these are finite."""

from __future__ import annotations

import pytest
from model_text import behaviour_of, faults, resolve

MODEL = """
component P {{
    outgoing message small with type: integer(0..9)
    outgoing message big with type: integer
    outgoing message half with type: double
    incoming message go with type: double
    behaviour {{
        variable a: {a}
        variable b: {b}
        variable c: integer(0..9)
        initial marked state s {{ {transition} }}
    }}
}}
{rest}
"""


def model(transition: str, rest: str, a: str = "integer(0..9)", b: str = "integer(0..9)") -> str:
    return MODEL.format(a=a, b=b, transition=transition, rest=rest)


def in_state(text: str) -> set[str]:
    return {v.name for v in behaviour_of(resolve(text), "P").variables if v.in_state}


@pytest.mark.parametrize(
    ("transition", "rest"),
    [
        ("transition if a > 3", ""),
        ("on response from small if a > 3", ""),
        ("", "requirement go needs P.a > 3"),
        ("", "requirement P.a > 3 disables go"),
        ("", "requirement never P.a > 3"),
        ("", "requirement always P.a > 3"),
        ("", "provide go with 3 if P.a > 3"),
    ],
)
def test_what_is_read_by_a_decision_is_in_the_state(transition: str, rest: str) -> None:
    assert in_state(model(transition, rest)) == {"a"}


def test_provided_data_alone_keeps_a_variable_out_of_the_state() -> None:
    text = model("on response from half do a := value", "provide go with P.a * 2", a="double")
    assert in_state(text) == set()


def test_a_variable_that_flows_into_the_state_is_in_it() -> None:
    text = model("on response from small do a := b, b := c", "requirement go needs P.a > 3")
    assert in_state(text) == {"a", "b", "c"}


def test_other_components_flow_into_the_state_too() -> None:
    rest = """
    component Q { behaviour {
        variable q: integer(0..9)
        initial marked state s { on response from small do q := P.c }
    } }
    requirement go needs Q.q > 3
    """
    assert in_state(model("", rest)) == {"c"}


def test_a_variable_that_is_compared_need_not_be_finite() -> None:
    assert in_state(model("", "requirement go needs P.a > 3", a="double")) == {"a"}


def test_what_is_copied_to_a_variable_that_is_compared_is_in_the_state() -> None:
    rest = "requirement go needs P.a > 3"
    text = model("on response from small do a := b, b := c * 0.5", rest, a="double", b="double")
    assert in_state(text) == {"a", "b"}


def test_the_source_of_a_state_variable_must_be_finite() -> None:
    text = model("on response from small do a := b", "requirement go needs P.a > 3", b="integer")
    assert ("not-finite", "b") in faults(text)


def test_a_state_variable_takes_ranged_values_from_messages_only() -> None:
    rest = "requirement go needs P.a > 3"
    assert ("not-finite", "value") in faults(model("on response from big do a := value", rest))
    assert in_state(model("on response from small do a := value", rest)) == {"a"}


def test_a_guard_compares_any_numbers() -> None:
    resolve(model("on response from half if value > 0.5", ""))
    resolve(model("on response from small if value > 5", ""))


def test_a_data_only_variable_takes_anything() -> None:
    text = model("on response from half do a := value", "provide go with P.a", a="double")
    assert not [f for f in faults(text) if f[0] == "not-finite"]
