"""Calls of functions, and ``in``: what they mean, and what is said where they do not fit."""

from __future__ import annotations

import pytest
from model_text import faults, resolve

from robosc.model.resolve import load
from robosc.plant.model_text import to_dsl
from robosc.source import Source

MODEL = """
datatype enum Way from double to { value > 1 -> free default -> blocked }
component P {
    incoming message go with type: double
    outgoing message i with type: integer
    outgoing message way with type: Way
    behaviour {
        variable n: integer(0..9)
        variable d: double
        variable t: string
        variable f: boolean
        variable w: Way
        initial marked state s { on response from way do w := value %s }
    }
}
requirement go needs %s
"""


def with_condition(condition: str) -> str:
    return MODEL % ("", condition)


@pytest.mark.parametrize(
    ("written", "meant"),
    [
        ("abs(P.n - 3) < 2", "abs(P.n - 3) < 2"),
        ("min(P.n, 3, 5) = 3", "min(min(P.n, 3), 5) = 3"),
        ("has(P.n, 1 + 4) and !isnan(P.d)", "has(P.n, 1 + 4) and !isnan(P.d)"),
        ("hypot(P.d, 2) >= sqrt(P.n)", "hypot(P.d, 2) >= sqrt(P.n)"),
        ("round(P.d) in {1, 2}", "round(P.d) = 1 or round(P.d) = 2"),
        ("P.w in {free, blocked}", "P.w = free or P.w = blocked"),
        ('P.t = "n" + string(P.n)', 'P.t = "n" + string(P.n)'),
        ("!(P.n in {3})", "!(P.n = 3)"),
        ("(P.d / 0 else P.d else 2) > 1", "(P.d / 0 else P.d else 2.0) > 1"),
        ("((P.d else 1) else 2) > 1", "((P.d else 1.0) else 2.0) > 1"),
        ("(P.f or P.n > 1 else true) and P.f", "(P.f or P.n > 1) and P.f"),
        ("(P.n + 1 else 2) > 1", "(P.n + 1 else 2) > 1"),
    ],
)
def test_calls_are_understood(written: str, meant: str) -> None:
    robot = resolve(with_condition(written))
    assert to_dsl(robot.requirements[0].condition, robot) == meant


def test_a_comparison_of_three_is_explained() -> None:
    source = Source("model.rscd", f"robot Test {{ {with_condition('1 < P.n < 5')} }}")
    _, diagnostics = load(source)
    (fault,) = (d for d in diagnostics if d.code == "type-mismatch")
    assert fault.hint == "write 1 < P.n and P.n < …"


def test_else_replaces_no_array() -> None:
    model = """
    datatype object Scan { ranges: array(double) }
    interface scan use Scan from example_msgs
    component P {
        outgoing message scan with type: Scan links scan
        behaviour {
            variable front: double
            initial marked state s {
                on response from scan do front := min(r for r in value.ranges else [0.0])
            }
        }
    }
    """
    assert ("type-mismatch", "value.ranges") in faults(model)


@pytest.mark.parametrize(
    ("condition", "fault"),
    [
        ("sqr(P.d) > 1", ("unknown-name", "sqr")),
        ("abs(P.f) > 1", ("type-mismatch", "P.f")),
        ("abs(P.d, 1) > 1", ("type-mismatch", "abs(P.d, 1)")),
        ("min(P.d) > 1", ("type-mismatch", "min(P.d)")),
        ("has(P.d, 1)", ("type-mismatch", "P.d")),
        ("has(P.n, 1) = 3", ("type-mismatch", "3")),
        ("abs(P.n)", ("type-mismatch", "abs(P.n)")),
        ("P.n in {1, true}", ("type-mismatch", "true")),
        ("P.w in {free, open}", ("unknown-name", "open")),
        ('P.t = "a" + 1', ("type-mismatch", "1")),
        ("P.n = 1 + P.t", ("type-mismatch", "P.t")),
        ("length(P.t) = 3", ("type-mismatch", "P.t")),
        ("(P.d else true) > 1", ("type-mismatch", "true")),
        ("(P.d else P.n) > 1", ("type-mismatch", "P.n")),
        ("(P.n else 0.5) > 1", ("type-mismatch", "0.5")),
    ],
)
def test_a_wrong_call_is_marked(condition: str, fault: tuple[str, str]) -> None:
    found = [each for each in faults(with_condition(condition)) if not each[0].startswith("unused")]
    assert found == [fault]
