"""Parts of arrays and what goes through them: typing, values, and the Python that is generated."""

from __future__ import annotations

import math
from types import SimpleNamespace

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from model_text import behaviour_of, faults, resolve

from robosc.emit.controller.python import access
from robosc.expr.evaluation import Undefined, evaluate
from robosc.expr.tree import ElementRef, Expr, ValueRef
from robosc.language.functions import HELPERS
from robosc.plant.model_text import to_dsl
from robosc.plant.python_text import element_name, to_python

MODEL = """
datatype object Point { x: double y: double more: array(integer) }
datatype object Cloud { ranges: array(double) points: array(Point) n: integer }
interface cloud use Cloud from example_msgs
component P {
    outgoing message cloud with type: Cloud links cloud
    behaviour {
        variable flag: boolean
        variable number: double
        variable whole: integer
        initial marked state s { on response from cloud do %s }
    }
}
"""

BOOLEANS = [
    "any(r < 0.5 for r in value.ranges)",
    "all(r < value.n for r in value.ranges if r != 0)",
    "any(p.x > p.y and has(p.more[0], 1) for p in value.points)",
    "all(p.more[1] > 0 for p in value.points if p.more[0] > 0)",
    "any(isnan(r) for r in value.ranges[-2..1])",
    "any(any(m > p.x for m in p.more) for p in value.points)",
    "value.ranges[value.n] > 1",
    "min(r for r in value.ranges) < 1 or value.n > 2",
    "any(r > i for i, r in value.ranges)",
    "any(r < 1 for r in [p.more[1] - i for i, p in value.points if p.more[0] > 0])",
    "first(p.x > p.more[i] for i, p in value.points if p.more[1] >= i)",
]
NUMBERS = [
    "count(r > 1 for r in value.ranges[value.n..value.n + 2])",
    "sum(r for r in value.ranges if r > 0)",
    "max(p.more[0] for p in value.points)",
    "min(length(p.more) for p in value.points)",
    "length(value.ranges[1..3]) + length(value.points)",
    "value.ranges[-1] + sum(value.ranges[m] for m in value.points[0].more)",
    "first(r for r in value.ranges[2..-1] if r > 0)",
    "first(p for p in value.points if p.x >= p.y).more[0]",
    "first(i for i, p in value.points if p.more[i] = 0) + length([r for r in value.ranges])",
    "count(r < value.ranges[i + 1] for i, r in value.ranges)",
    "sum(p.more[i] for i, p in value.points if p.x > i)",
    "[value.ranges[i + value.n] for i, r in value.ranges if r > 0][-1]",
    "max(length([m for m in p.more if m > i]) for i, p in value.points)",
]


def assigned(text: str, variable: str) -> Expr:
    robot = resolve(MODEL % f"{variable} := {text}")
    (transition,) = behaviour_of(robot, "P").states[0].transitions
    value = transition.assignments[0].value
    assert to_dsl(value, robot) == text
    return value


doubles = st.sampled_from([0.0, 0.25, 0.5, 1.0, 2.5, -1.0, math.inf, math.nan])
points = st.builds(
    lambda x, y, more: SimpleNamespace(x=x, y=y, more=more),
    doubles,
    doubles,
    st.lists(st.integers(-2, 3), max_size=3),
)
clouds = st.builds(
    lambda ranges, points, n: SimpleNamespace(ranges=ranges, points=points, n=n),
    st.lists(doubles, max_size=5),
    st.lists(points, max_size=3),
    st.integers(-3, 4),
)


def outcome(function: object) -> object:
    try:
        return repr(function())  # type: ignore[operator]
    except IndexError:  # as Undefined is
        return "undefined"


def spelled(leaf: object) -> str:
    """A leaf as generated code has it."""
    if isinstance(leaf, ElementRef):
        return access(element_name(leaf.variable), leaf.path)
    assert isinstance(leaf, ValueRef)
    return f"part({leaf.path!r})"


@pytest.mark.parametrize(
    ("text", "variable"), [(t, "flag") for t in BOOLEANS] + [(t, "number") for t in NUMBERS]
)
def test_generated_python_means_the_expression(text: str, variable: str) -> None:
    expr = assigned(text, variable)

    text = to_python(expr, spelled, part=lambda node, whole: access(whole, node.path))
    code = compile(text, "generated", "eval")

    @settings(max_examples=40)
    @given(clouds)
    def check(cloud: SimpleNamespace) -> None:
        def part(path: tuple[str | int, ...]) -> object:
            value: object = cloud
            for step in path:
                try:
                    value = getattr(value, step) if isinstance(step, str) else value[step]  # type: ignore[index]
                except IndexError:
                    raise Undefined from None
            return value

        found = outcome(lambda: eval(code, {**HELPERS, "part": part}))
        assert found == outcome(lambda: evaluate(expr, lambda leaf: part(leaf.path)))  # type: ignore[arg-type,return-value,union-attr]

    check()


@pytest.mark.parametrize(
    ("section", "found"),
    [
        ((1, 2), [1, 2]), ((0, 9), [0, 1, 2, 3, 4]), ((-2, 1), [3, 4, 0, 1]), ((3, 1), [3, 4, 0, 1]),
        ((-2, -1), [3, 4]), ((7, 9), []), ((-9, 1), [0, 1]), ((2, 2), [2]), ((4, 0), [4, 0]),
    ],
)  # fmt: skip
def test_a_section_may_run_over_the_end(section: tuple[int, int], found: list[int]) -> None:
    assert HELPERS["section"]([0, 1, 2, 3, 4], *section) == found
    assert HELPERS["section"]([], *section) == []


@pytest.mark.parametrize(
    ("section", "found"), [((-3, -3), []), ((-5, -4), []), ((-3, -2), [0]), ((-4, 0), [0])]
)
def test_a_section_before_the_beginning_is_not_there(
    section: tuple[int, int], found: list[int]
) -> None:
    assert HELPERS["section"]([0, 1], *section) == found


@pytest.mark.parametrize(
    ("text", "fault"),
    [
        ("flag := any(r for r in value.ranges)", ("type-mismatch", "r")),
        ("flag := any(r < 1 for r in value.n)", ("type-mismatch", "value.n")),
        ("flag := any(r < 1 for r in value.ranges if r)", ("type-mismatch", "r")),
        ("flag := any(p.z < 1 for p in value.points)", ("unknown-member", "z")),
        ("flag := value.ranges[0.5] > 1", ("type-mismatch", "0.5")),
        ("flag := any(any(r > 1 for r in value.ranges) for r in value.ranges)",
         ("duplicate-name", "r")),
        ("whole := sum(r for r in value.ranges)", ("type-mismatch", "sum(r for r in value.ranges)")),
        ("number := mean(r for r in value.ranges)", ("unknown-name", "mean")),
        ("flag := any(r > 1 for r in value.ranges) and r > 1", ("unknown-name", "r")),
    ],
)  # fmt: skip
def test_a_wrong_part_is_marked(text: str, fault: tuple[str, str]) -> None:
    left_out = ("unused", "package", "unread")
    assert [f for f in faults(MODEL % text) if not f[0].startswith(left_out)] == [fault]
