"""``parameter far: double(0.1..2.0) = 0.5``: what its range decides, and who keeps to it."""

from __future__ import annotations

import operator
from pathlib import Path

import pytest
from hypothesis import given
from hypothesis import strategies as st
from model.model_text import faults, resolve

from robosc import pipeline
from robosc.expr.evaluation import evaluate
from robosc.expr.tree import Binary, Literal, ParameterRef, RosParameter
from robosc.expr.types import BooleanType, DoubleType
from robosc.model.typing.expressions import decided
from robosc.simulate.faults import InvalidLine
from robosc.simulate.script.session import Session
from robosc.simulate.start import machine_maker
from robosc.source import Source, Span

OPERATORS = {
    "<": operator.lt, "<=": operator.le, ">": operator.gt, ">=": operator.ge,
    "=": operator.eq, "!=": operator.ne,
}  # fmt: skip
MODEL = """robot Cart {
    parameter far: double(0.1..2) = 0.5
    component Base {
        outgoing message front with timeout: 1 s, type: double
        incoming message go with type: none
        behaviour {
            variable near: double
            initial marked state rest { on response from front do near := value on request to go }
        }
    }
    requirement go needs front.fresh and Base.near > far CONDITION
    stop with nothing
}"""


@given(
    st.sampled_from(sorted(OPERATORS)),
    st.tuples(st.integers(-4, 4), st.integers(0, 4)),
    st.integers(-6, 10),
    st.booleans(),
)
def test_it_is_decided_exactly_where_all_values_agree(
    sign: str, bounds: tuple[int, int], limit: int, swapped: bool
) -> None:
    low, high = float(bounds[0]), float(bounds[0] + bounds[1])
    span = Span(Source("m", ""), 0, 0)
    parameter = ParameterRef(RosParameter("far", DoubleType(), low, span, bounds=(low, high)))
    sides = (Literal(float(limit), DoubleType()), parameter)
    left, right = sides if swapped else sides[::-1]
    found = decided(Binary(sign, left, right, BooleanType()))
    values = {low, high, *(low + (high - low) * n / 16 for n in range(17))}
    outcomes = {OPERATORS[sign](limit, v) if swapped else OPERATORS[sign](v, limit) for v in values}
    if isinstance(found, Literal):
        assert outcomes == {found.value}
    else:
        assert len(outcomes) == 2 or (sign in "=!=" and low <= limit <= high)


def test_the_range_is_known_to_synthesis(tmp_path: Path) -> None:
    path = tmp_path / "cart.rscd"
    for condition, code in (("and far < 0.1", "requirement-never-met"), ("and far < 3.0", None)):
        path.write_text(MODEL.replace("CONDITION", condition), encoding="utf-8")
        found = {d.code for d in pipeline.check(path).diagnostics}
        assert ("requirement-never-met" in found) == (code is not None)


def test_a_value_outside_is_refused_at_the_start(tmp_path: Path) -> None:
    path = tmp_path / "cart.rscd"
    path.write_text(MODEL.replace("CONDITION", ""), encoding="utf-8")
    supervisor = pipeline.supervise(pipeline.load(path).robot)
    for value in (0.1, 1, 2.0):
        Session(machine_maker(supervisor, execute=True), {"far": value})
    for value in (0.09, 2.001, -1, float("nan"), float("inf")):
        with pytest.raises(InvalidLine, match="far"):
            Session(machine_maker(supervisor, execute=True), {"far": value})


@pytest.mark.parametrize(
    ("declaration", "code"),
    [
        ("parameter p: double(0.1..2.0) = 2.5", "out-of-range"),
        ("parameter p: double(2.0..0.1) = 1.0", "empty-range"),
        ("parameter p: double(0.1..) = 1.0", "syntax"),
        ("parameter p: double(a..b) = 1.0", "syntax"),
        ("constant p: double(0.1..2.0) = 1.0", "syntax"),
        ("parameter p: array(double(0.1..2.0)) = [1.0]", "syntax"),
    ],
)
def test_faults(declaration: str, code: str) -> None:
    assert code in [found for found, _ in faults(declaration)]


def test_what_an_import_sets_is_in_the_range(tmp_path: Path) -> None:
    library = "library Base { component Cart { parameter far: double(0.1..2.0) = 0.5"
    library += " incoming message go with type: double, stop: none } }"
    (tmp_path / "base.rscd").write_text(library, encoding="utf-8")
    path = tmp_path / "cart.rscd"
    for value, is_right in (("1.5", True), ("2.5", False)):
        path.write_text(
            f"robot R {{ component C from Base import Cart with far: {value} }}", encoding="utf-8"
        )
        codes = [d.code for d in pipeline.check(path).diagnostics]
        assert ("out-of-range" not in codes) == is_right


def test_the_default_may_be_a_bound() -> None:
    robot = resolve("parameter low: double(-1.5..2) = -1.5 parameter high: double(-1..2.5) = 2.5")
    assert [(p.bounds, p.default) for p in robot.parameters] == [
        ((-1.5, 2.0), -1.5),
        ((-1.0, 2.5), 2.5),
    ]
    assert evaluate(ParameterRef(robot.parameters[0]), lambda leaf: leaf.parameter.default) == -1.5
