"""The call that is being typed: what its function takes, and which argument the cursor is in."""

from __future__ import annotations

import pytest
from lsp_support import cursor, open_text

from robosc.language.functions import FUNCTIONS, GEOMETRY
from robosc.lsp.analysis import Workspace
from robosc.lsp.hover import Signature, signature_at

MODEL = """\
robot R {{
    function mean(left: double, right: double): double = (left + right) / 2
    component Gate {{
        function half(x: double): double = x / 2
        outgoing message level with type: double
        incoming message open with type: none
        behaviour {{
            variable a: double = 0.0
            initial marked state on {{ on response from level do a := value }}
        }}
    }}
    requirement open needs {0}
}}
"""


def asked(expression: str) -> Signature | None:
    text, offset = cursor(MODEL.format(expression))
    return signature_at(open_text(Workspace([]), "/r.rscd", text), offset)


@pytest.mark.parametrize(
    ("expression", "label", "active"),
    [
        ("mean(|", "mean(left: double, right: double): double", "left: double"),
        ("mean(Gate.a, |) > 1", "mean(left: double, right: double): double", "right: double"),
        ("half(mean(1, 2) + |", "half(x: double): double", "x: double"),
        ("mean((1 + |), 2) > 1", "mean(left: double, right: double): double", "left: double"),
        ("mean([1, 2|][0], 2)", "mean(left: double, right: double): double", "left: double"),
        ("has(3, |", "has(integer, integer): boolean", "integer"),
        ("min(1, 2, 3, |", "min(number, number, …): integer if all operands are, else double", "…"),
        ("distance(Gate.a, |", "distance(a point, a point)", "a point"),
    ],
)
def test_the_argument_that_is_being_typed(expression: str, label: str, active: str) -> None:
    found = asked(expression)
    assert found is not None
    start, end = [*found.places][found.active]
    assert (found.label, found.label[start:end]) == (label, active)


@pytest.mark.parametrize(
    "expression",
    [
        "|mean(1, 2) > 1",
        "mean(1, 2)| > 1",
        "(|1 > 2)",
        "unknown(|",
        "mean(1, 2, |",
        "half(/* | */ 1",
    ],
)
def test_where_there_is_no_call(expression: str) -> None:
    assert asked(expression) is None


def test_a_declaration_is_no_call() -> None:
    text = MODEL.format("true").replace("mean(left", "mean(|left")
    text, offset = cursor(text)
    assert signature_at(open_text(Workspace([]), "/r.rscd", text), offset) is None


@pytest.mark.parametrize("name", [*FUNCTIONS, *GEOMETRY])
def test_every_function_has_one(name: str) -> None:
    found = asked(f"{name}(|")
    assert found is not None
    assert found.arguments
    assert found.active == 0
