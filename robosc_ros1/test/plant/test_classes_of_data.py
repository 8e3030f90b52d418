"""The classes of numbers and strings: exact for every value, NaN and neighbours of constants too."""

from __future__ import annotations

import math

import pytest
from hypothesis import example, given
from hypothesis import strategies as st

from robosc.expr.evaluation import evaluate
from robosc.expr.tree import VariableRef
from robosc.expr.types import DoubleType, IntegerType, StringType, Type
from robosc.language.operators import BINARY
from robosc.plant.data.classes import Classes

X = VariableRef("A", "x", DoubleType())
OPERATORS = st.sampled_from(["=", "!=", "<", "<=", ">", ">="])
SPECIAL = [0.0, -0.0, 0.1, 0.2, 1.0, math.inf, -math.inf, 5e-324, 1.7976931348623157e308, 2.0**53]
NUMBERS = st.one_of(
    st.sampled_from(SPECIAL),
    st.floats(allow_nan=False),
    st.integers(-5, 5),
    st.sampled_from([2**53 + 1, 10**400, -(10**400)]),
)
COMPARISONS = st.lists(st.tuples(OPERATORS, NUMBERS), max_size=5).map(frozenset)


def near(constant: int | float) -> list[float]:
    """A constant as a double, and the doubles beside it."""
    try:
        double = float(constant)
    except OverflowError:
        double = math.inf if constant > 0 else -math.inf
    return [math.nextafter(double, -math.inf), double, math.nextafter(double, math.inf)]


def outcomes(comparisons: frozenset, value: object) -> list[bool]:
    return [BINARY[op].scalar(value, constant) for op, constant in sorted(comparisons, key=repr)]


def values_of(type_: Type, comparisons: frozenset) -> list[int | float]:
    """Values of all kinds, those close to the constants above all."""
    constants = [constant for _, constant in comparisons]
    doubles = [*SPECIAL, *(value for constant in constants for value in near(constant))]
    if isinstance(type_, DoubleType):
        return [*doubles, math.nan]
    whole = [int(value) for value in doubles if math.isfinite(value)]
    whole += [c for c in constants if isinstance(c, int)]
    return [value + step for value in whole for step in (-1, 0, 1)]


@pytest.mark.parametrize("type_", [DoubleType(), IntegerType()])
@given(comparisons=COMPARISONS)
@example(comparisons=frozenset({(">", 0.2), ("<=", math.nextafter(0.2, 1.0))}))
@example(comparisons=frozenset({(">", 0.2), ("<=", 0.2)}))
@example(comparisons=frozenset({("<=", math.inf), (">=", -math.inf)}))
def test_values_are_in_one_class_if_and_only_if_all_comparisons_agree(
    type_: Type, comparisons: frozenset
) -> None:
    classes = Classes(type_, comparisons)
    told = [outcomes(comparisons, representative) for representative in classes]
    assert all(one != other for n, one in enumerate(told) for other in told[:n])
    for value in values_of(type_, comparisons):
        assert value in classes
        assert told[classes.index(value)] == outcomes(comparisons, value)


@pytest.mark.parametrize("type_", [DoubleType(), IntegerType()])
@given(comparisons=COMPARISONS, data=st.data())
@example(comparisons=frozenset({(">", 0.2), ("<=", 0.2)}), data=None)
def test_conditions_hold_in_what_is_needed_and_nowhere_but_in_what_is_free(
    type_: Type, comparisons: frozenset, data: st.DataObject | None
) -> None:
    classes = Classes(type_, comparisons)
    numbers = list(range(len(classes)))
    if data is None:
        needed, free = [n for n in numbers if not _is_nan(classes[n])], numbers[:2]
    else:
        free = data.draw(st.lists(st.sampled_from(numbers), unique=True))
        needed = [n for n in free if data.draw(st.booleans())]
    condition = classes.condition(needed, free).of(X)
    for value in values_of(type_, comparisons):
        holds = evaluate(condition, lambda leaf, v=value: v)
        if classes.index(value) in needed:
            assert holds, (value, condition)
        elif classes.index(value) not in free:
            assert not holds, (value, condition)


def _is_nan(value: object) -> bool:
    return value != value


@given(st.lists(st.tuples(st.sampled_from(["=", "!="]), st.sampled_from(["", "a", "?", "b"]))))
def test_classes_of_strings(comparisons: list[tuple[str, str]]) -> None:
    told_apart = frozenset(comparisons)
    classes = Classes(StringType(), told_apart)
    name = VariableRef("A", "name", StringType())
    for value in ["", "a", "?", "??", "b", "other"]:
        number = classes.index(value)
        assert outcomes(told_apart, classes[number]) == outcomes(told_apart, value)
        for other in range(len(classes)):
            condition = classes.condition([other], [other]).of(name)
            assert evaluate(condition, lambda leaf, v=value: v) == (other == number)


def test_what_is_told_apart_by_nothing_is_one_class() -> None:
    assert list(Classes(DoubleType(), frozenset())) == [0.0]
    assert list(Classes(IntegerType(), frozenset({(">", 10**400)}))) == [
        10**400 - 1,
        10**400 + 1,
    ]


def test_a_class_that_no_value_of_the_type_is_in_is_left_out() -> None:
    between = Classes(DoubleType(), frozenset({(">", 0.1), (">=", math.nextafter(0.1, 1.0))}))
    assert len(between) == 2
    assert len(Classes(IntegerType(), frozenset({(">", 2), ("<", 3)}))) == 2


def test_representatives_are_round() -> None:
    classes = Classes(DoubleType(), frozenset({(">", 0.1), (">", 0.2)}))
    assert list(classes) == [-0.9, 0.15, 1.2]


@pytest.mark.parametrize("type_", [DoubleType(), StringType()])
def test_many_classes_take_time_in_proportion(type_: Type) -> None:
    constants = [str(n) if type_ == StringType() else n + 0.5 for n in range(20_000)]
    operator = "=" if type_ == StringType() else ">"
    classes = Classes(type_, frozenset((operator, constant) for constant in constants))
    assert len(classes) == 20_001
    for number, value in enumerate(classes):
        assert classes.index(value) == number
        length, _ = classes.condition([number], [number]).length
        assert length <= 2 or number == 20_000  # which no string that is asked for equals
