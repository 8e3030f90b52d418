"""The reference interpreter of generated tests knows the operators of the language's table."""

from __future__ import annotations

import importlib
import math
from array import array
from collections.abc import Callable, Iterator
from itertools import product
from types import SimpleNamespace
from typing import Any

import numpy
import pytest
from emit.generated_code import supervisor_of
from emit.judged_controllers import judging_modules

from robosc.expr.evaluation import evaluate
from robosc.expr.tree import Binary, Call, Literal, Unary
from robosc.expr.types import ArrayType, BooleanType, DoubleType, IntegerType
from robosc.language.functions import AGGREGATES, CALLS
from robosc.language.operators import BINARY, UNARY, Operand, Operator

NUMBERS = (0, 1, -1, 2, -3, 7, 10**400, -(10**400), 0.0, -0.0, 0.5, -2.5, 1e308, math.inf, -math.inf,
           math.nan)  # fmt: skip
BOOLEANS = (False, True)


@pytest.fixture(scope="module")
def shadow(tmp_path_factory: pytest.TempPathFactory) -> Iterator[SimpleNamespace]:
    """What the interpreter's modules define, in one place."""
    supervisor = supervisor_of("robot R { component A { outgoing message a with type: boolean } }")
    with judging_modules(tmp_path_factory.mktemp("reference"), supervisor):
        names: dict[str, Any] = {}
        for name in ("operations", "message_fields", "reference_model"):
            names |= vars(importlib.import_module(name))
        yield SimpleNamespace(**names)


def literal(value: float) -> Literal:
    types = {bool: BooleanType(), int: IntegerType(), float: DoubleType()}
    return Literal(value, types[type(value)])


def same(left: object, right: object) -> bool:
    """Equal in type and value, NaN to itself, 0.0 not to -0.0."""
    return type(left) is type(right) and repr(left) == repr(right)


@pytest.mark.parametrize("operator", BINARY.values(), ids=BINARY)
def test_binary_operators_mean_the_same(shadow: SimpleNamespace, operator: Operator) -> None:
    interpreter = shadow.ReferenceModel.__new__(shadow.ReferenceModel)
    values = BOOLEANS if operator.operands is Operand.BOOLEAN else NUMBERS
    for left in values:
        for right in values:
            expr = Binary(operator.spelling, literal(left), literal(right), BooleanType())
            tree = [operator.key, ["literal", left], ["literal", right]]
            expected = evaluate(expr, lambda leaf: None)
            assert same(interpreter.evaluate(tree), expected), tree


@pytest.mark.parametrize("operator", UNARY.values(), ids=UNARY)
def test_unary_operators_mean_the_same(shadow: SimpleNamespace, operator: Operator) -> None:
    interpreter = shadow.ReferenceModel.__new__(shadow.ReferenceModel)
    for value in BOOLEANS if operator.operands is Operand.BOOLEAN else NUMBERS:
        expected = evaluate(Unary(operator.spelling, literal(value), BooleanType()), lambda _: None)
        assert same(interpreter.evaluate([operator.key, ["literal", value]]), expected), value


UNDEFINED = Call(
    "element", (Literal((), ArrayType(DoubleType())), Literal(0, IntegerType())), DoubleType()
)


def test_else_replaces_what_is_undefined(shadow: SimpleNamespace) -> None:
    interpreter = shadow.ReferenceModel.__new__(shadow.ReferenceModel)
    missing = ["element", ["literal", ()], ["literal", 0]]
    for value in (*NUMBERS, *BOOLEANS):
        expr = Binary("else", UNDEFINED, literal(value), DoubleType())
        assert same(evaluate(expr, lambda leaf: None), value)
        assert same(interpreter.evaluate(["else", missing, ["literal", value]]), value)
    both = Binary("else", UNDEFINED, UNDEFINED, DoubleType())
    assert outcome(lambda: evaluate(both, lambda leaf: None)) == "undefined"
    assert outcome(lambda: interpreter.evaluate(["else", missing, missing])) == "undefined"


@pytest.mark.parametrize(
    ("aggregate", "results", "expected"),
    [
        ("min", [math.nan, 2.0, math.nan, 0.5], 0.5),
        ("max", [math.nan, 2.0, math.nan, 0.5], 2.0),
        ("min", [math.nan, math.nan], "undefined"),
        ("max", [math.nan], "undefined"),
    ],
)
def test_erroneous_readings_count_as_missing(
    aggregate: str, results: list[float], expected: float | str
) -> None:
    assert outcome(lambda: AGGREGATES[aggregate].scalar(results)) == expected


def outcome(function: Callable[[], object]) -> object:
    """A result, or the text that there is none."""
    try:
        return function()
    except Exception as fault:
        assert type(fault).__name__ == "Undefined"
        return "undefined"


ARGUMENTS = {
    Operand.NUMBER: NUMBERS,
    Operand.INTEGER: [0, 1, -1, 2, 3, 6, 255, -(2**70)],
    Operand.BASIC: [True, False, "some text", 3, -0.5],
    Operand.ARRAY: [(), (1, 2.5), tuple(range(7))],
}


@pytest.mark.parametrize("function", CALLS.values(), ids=CALLS)
def test_functions_mean_the_same(shadow: SimpleNamespace, function: Operator) -> None:
    interpreter = shadow.ReferenceModel.__new__(shadow.ReferenceModel)
    # All combinations of what is best are enough of a function with many arguments.
    few = slice(None) if len(function.arguments) < 4 else slice(2, None, 4)
    for values in product(*(ARGUMENTS[kind][few] for kind in function.arguments)):
        tree = [function.key, *(["literal", value] for value in values)]
        expected = outcome(lambda values=values: function.scalar(*values))
        assert same(outcome(lambda tree=tree: interpreter.evaluate(tree)), expected), values


RESULTS = ([], [False], [True, False, True], [True, True])
LISTS = ([], [1], [3, -2, 5.5], [0.0, -0.0], [1, math.nan, 0], [10**400, 0.5], [2, 2.0])


@pytest.mark.parametrize("aggregate", AGGREGATES.values(), ids=AGGREGATES)
def test_aggregates_mean_the_same(shadow: SimpleNamespace, aggregate: Operator) -> None:
    for results in RESULTS if aggregate.operands is Operand.BOOLEAN else LISTS:
        expected = outcome(lambda results=results: aggregate.scalar(results))
        found = outcome(lambda results=results: shadow.AGGREGATES[aggregate.spelling](results))
        assert same(found, expected), results


def test_the_table_of_the_reference_interpreter_holds_nothing_else(shadow: SimpleNamespace) -> None:
    assert set(shadow.FUNCTIONS) == set(CALLS)
    assert set(shadow.AGGREGATES) == set(AGGREGATES)
    assert set(shadow.OPERATORS) == {
        o.key for o in BINARY.values() if not o.is_lazy and o.spelling != "else"
    }


@pytest.mark.parametrize(
    "slots", [("header", "progress"), ("_header", "_progress", "_check_fields")]
)
def test_the_only_field_of_a_message_of_either_ros(
    shadow: SimpleNamespace, slots: tuple[str, ...]
) -> None:
    """As needed where its definition was not installed when the package was generated."""
    message = type("Message", (), {"__slots__": slots})()
    assert shadow.only_field(message) == "progress"


def test_arrays_and_numbers_of_numpy_are_plain_ones(shadow: SimpleNamespace) -> None:
    """In rclpy's messages, arrays of fixed length are such."""
    message = {"three": numpy.array([1, -2, 3], "int8"), "many": array("d", [0.5])}
    found = shadow.plain([message, numpy.uint64(2**64 - 1)])
    assert repr(found) == repr([{"three": [1, -2, 3], "many": [0.5]}, 2**64 - 1])
