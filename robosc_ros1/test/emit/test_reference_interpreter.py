"""The reference interpreter of generated tests knows the operators of the language's table."""

from __future__ import annotations

import math
from itertools import product
from types import ModuleType

import pytest

from robosc.emit.engine import verbatim
from robosc.language.functions import FUNCTIONS
from robosc.language.operators import BINARY, UNARY, Operand, Operator
from robosc.model.evaluation import evaluate
from robosc.model.expr import Binary, Literal, Unary
from robosc.model.types import BooleanType, DoubleType, IntegerType

NUMBERS = (0, 1, -1, 2, -3, 7, 10**400, -(10**400), 0.0, -0.0, 0.5, -2.5, 1e308, math.inf, -math.inf,
           math.nan)  # fmt: skip
BOOLEANS = (False, True)


@pytest.fixture(scope="module")
def shadow() -> ModuleType:
    module = ModuleType("shadow")
    exec(verbatim("common/shadow.py"), module.__dict__)
    return module


def literal(value: float) -> Literal:
    types = {bool: BooleanType(), int: IntegerType(), float: DoubleType()}
    return Literal(value, types[type(value)])


def same(left: object, right: object) -> bool:
    """Equal in type and value, NaN to itself, 0.0 not to -0.0."""
    return type(left) is type(right) and repr(left) == repr(right)


@pytest.mark.parametrize("operator", BINARY.values(), ids=BINARY)
def test_binary_operators_mean_the_same(shadow: ModuleType, operator: Operator) -> None:
    interpreter = shadow.Shadow.__new__(shadow.Shadow)
    values = BOOLEANS if operator.operands is Operand.BOOLEAN else NUMBERS
    for left in values:
        for right in values:
            expr = Binary(operator.spelling, literal(left), literal(right), BooleanType())
            tree = [operator.key, ["literal", left], ["literal", right]]
            expected = evaluate(expr, lambda leaf: None)
            assert same(interpreter.evaluate(tree), expected), tree


@pytest.mark.parametrize("operator", UNARY.values(), ids=UNARY)
def test_unary_operators_mean_the_same(shadow: ModuleType, operator: Operator) -> None:
    interpreter = shadow.Shadow.__new__(shadow.Shadow)
    for value in BOOLEANS if operator.operands is Operand.BOOLEAN else NUMBERS:
        expected = evaluate(Unary(operator.spelling, literal(value), BooleanType()), lambda _: None)
        assert same(interpreter.evaluate([operator.key, ["literal", value]]), expected), value


ARGUMENTS = {
    Operand.NUMBER: NUMBERS,
    Operand.INTEGER: [0, 1, -1, 2, 3, 6, 255, -(2**70)],
    Operand.BASIC: [True, False, "some text", 3, -0.5],
    Operand.ARRAY: [(), (1, 2.5)],
}


@pytest.mark.parametrize("function", FUNCTIONS.values(), ids=FUNCTIONS)
def test_functions_mean_the_same(shadow: ModuleType, function: Operator) -> None:
    interpreter = shadow.Shadow.__new__(shadow.Shadow)
    for values in product(*(ARGUMENTS[kind] for kind in function.arguments)):
        found = interpreter.evaluate([function.key, *(["literal", value] for value in values)])
        assert same(found, function.scalar(*values)), values


def test_the_table_of_the_reference_interpreter_holds_nothing_else(shadow: ModuleType) -> None:
    assert set(shadow.FUNCTIONS) == set(FUNCTIONS)
    assert set(shadow.OPERATORS) == {o.key for o in BINARY.values() if not o.is_lazy}
