"""Expressions over arrays mean exactly what they mean one by one."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from synthesis.plants import plant_of

from robosc.expr.evaluation import evaluate
from robosc.expr.tree import Binary, Call, Expr, Leaf, Literal, StateRef, Unary, VariableRef
from robosc.expr.types import BooleanType, DoubleType, EnumType, IntegerType, Type, Value
from robosc.language.functions import CALLS, FUNCTIONS
from robosc.language.operators import BINARY, UNARY, Operand, Operator, Result
from robosc.model.typing.compatibility import result_type
from robosc.plant.automaton import Plant
from robosc.plant.support import support
from robosc.synthesis.vectorised import evaluate_vectorised

PLANT: Plant = plant_of(
    "datatype enum Colour from integer to { value = 1 -> red value = 2 -> green default -> blue }"
    " component A { incoming message go with type: none outgoing message m with type: none"
    " behaviour { variable x: integer(-3..3) variable y: integer(0..4)"
    " variable huge: integer(4611686018427387900..4611686018427387906) = 4611686018427387901"
    " variable b: boolean variable c: Colour"
    " initial marked state one { on response from m goto two }"
    " marked state two { on response from m goto one } } }"
    " requirement go needs A.x + A.y + A.huge > 0 or A.b or A.c = red"
)
ARITHMETIC = [o.spelling for o in BINARY.values() if o.result is not Result.BOOLEAN]
BOOLEAN, INTEGER, DOUBLE = BooleanType(), IntegerType(), DoubleType()


def _leaves(type_: object) -> list[Expr]:
    found: list[Expr] = []
    for variable in PLANT.variables:
        if "." in variable.name:
            component, name = variable.name.split(".")
            variable = next(
                v for v in PLANT.robot.component(component).behaviour.variables if v.name == name
            )
            found.append(VariableRef(component, name, variable.type))
    return [leaf for leaf in found if isinstance(leaf.type, type_)]


integers = (
    st.sampled_from(_leaves(IntegerType))
    | st.integers(-(2**70), 2**70).map(lambda v: Literal(v, INTEGER))
    | st.integers(-4, 4).map(lambda v: Literal(v, INTEGER))
)
doubles = st.floats(allow_nan=False, width=64).map(lambda v: Literal(v, DOUBLE))
enums = st.sampled_from(_leaves(EnumType)) | st.sampled_from(["red", "green", "blue"]).map(
    lambda v: Literal(v, _leaves(EnumType)[0].type)
)


def _arithmetic(inner: st.SearchStrategy[Expr]) -> st.SearchStrategy[Expr]:
    def join(op: str, left: Expr, right: Expr) -> Expr:
        return Binary(op, left, right, result_type(BINARY[op].result, (left.type, right.type)))

    def call(function: str, *operands: Expr) -> Expr:
        type_ = result_type(FUNCTIONS[function].result, [operand.type for operand in operands])
        return Call(function, operands, type_)

    calls = st.builds(call, st.sampled_from(["abs", "floor", "round"]), inner)
    calls |= st.builds(call, st.sampled_from(["min", "max"]), inner, inner)
    return (
        calls
        | st.builds(join, st.sampled_from(ARITHMETIC), inner, inner)
        | inner.map(lambda e: Unary("-", e, e.type))
    )


numbers = st.recursive(integers | doubles, _arithmetic, max_leaves=5)
atoms = (
    st.builds(
        lambda op, left, right: Binary(op, left, right, BOOLEAN),
        st.sampled_from(["=", "!=", "<", "<=", ">", ">="]),
        numbers,
        numbers,
    )
    | st.builds(
        lambda op, left, right: Binary(op, left, right, BOOLEAN),
        st.sampled_from(["=", "!="]),
        enums,
        enums,
    )
    | st.sampled_from(_leaves(BooleanType))
    | st.sampled_from([StateRef("A", "one"), StateRef("A", "two")])
)
conditions = st.recursive(
    atoms,
    lambda inner: (
        st.builds(
            lambda op, left, right: Binary(op, left, right, BOOLEAN),
            st.sampled_from(["and", "or", "=>", "=", "!="]),
            inner,
            inner,
        )
        | inner.map(lambda e: Unary("!", e, BOOLEAN))
    ),
    max_leaves=6,
)


def _one_by_one(expr: Expr, indexes: dict[int, int]) -> Value:
    def lookup(leaf: Leaf) -> Value:
        variable = PLANT.variable_of(leaf)
        assert variable is not None
        value = PLANT.variables[variable].values[indexes[variable]]
        return value == leaf.state if isinstance(leaf, StateRef) else value

    return evaluate(expr, lookup)


def check(expr: Expr) -> None:
    variables = support(PLANT, expr)
    sizes = [PLANT.variables[variable].size for variable in variables]
    grid = np.ogrid[tuple(slice(size) for size in sizes)] if variables else []
    found = evaluate_vectorised(PLANT, expr, dict(zip(variables, grid, strict=True)))
    everywhere = np.broadcast_to(found, sizes)
    for place in np.ndindex(*sizes):
        try:
            expected = _one_by_one(expr, dict(zip(variables, place, strict=True)))
        except OverflowError:  # an integer beyond the doubles meets one: no model comes near
            continue
        got = everywhere[place]
        if isinstance(expected, str):
            expected = PLANT_COLOURS.index(expected)
        same = math.isnan(got) if expected != expected else got == expected
        assert same, (place, got, expected)


PLANT_COLOURS = ("red", "green", "blue")


@pytest.mark.parametrize("operation", BINARY.values(), ids=BINARY)
def test_every_operator(operation: Operator) -> None:
    """Each on its own, so that no entry of its row is hidden by what is around it."""
    x, y = _leaves(IntegerType)[:2]
    one, two = StateRef("A", "one"), _leaves(BooleanType)[0]
    on_booleans = operation.operands in (Operand.BOOLEAN, Operand.EQUAL)
    pairs = [(one, two), (two, one)] if on_booleans else []
    if operation.operands is not Operand.BOOLEAN:
        pairs += [(x, y), (y, x), (x, Literal(2, INTEGER)), (x, Literal(0.5, DOUBLE))]
    for left, right in pairs:
        if operation.result is not Result.SAME or left.type == right.type:
            check(Binary(operation.spelling, left, right, type_of(operation, left, right)))


@pytest.mark.parametrize("function", CALLS.values(), ids=CALLS)
def test_every_function(function: Operator) -> None:
    if Operand.ARRAY in function.arguments or function.result is Result.STRING:
        return  # of data, which is not in the state
    x, y = _leaves(IntegerType)[:2]
    for operands in ((x, y), (y, x)):
        given = operands[: len(function.arguments)]
        check(Call(function.spelling, given, type_of(function, *given)))


@pytest.mark.parametrize("operation", UNARY.values(), ids=UNARY)
def test_every_unary_operator(operation: Operator) -> None:
    kind = BooleanType if operation.operands is Operand.BOOLEAN else IntegerType
    for leaf in _leaves(kind)[:2]:
        check(Unary(operation.spelling, leaf, type_of(operation, leaf)))


def type_of(operation: Operator, *operands: Expr) -> Type:
    return result_type(operation.result, [operand.type for operand in operands])


@pytest.mark.slow
@settings(max_examples=300)
@given(conditions)
def test_conditions(expr: Expr) -> None:
    check(expr)


@settings(max_examples=150)
@given(
    st.recursive(
        integers,
        lambda inner: st.builds(
            lambda op, left, right: Binary(op, left, right, INTEGER),
            st.sampled_from("+-*%"),
            inner,
            inner,
        ),
        max_leaves=5,
    )
)
def test_integers_never_overflow(expr: Expr) -> None:
    check(expr)
