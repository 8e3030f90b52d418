"""Expressions: what they mean, and that their DSL and Python texts mean the same."""

from __future__ import annotations

import math

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from model.model_text import resolve

from robosc.expr.evaluation import Undefined, evaluate
from robosc.expr.tree import FALSE, TRUE, Binary, Call, Literal, Unary, ValueRef, VariableRef
from robosc.expr.types import BooleanType, DoubleType, IntegerType, StringType
from robosc.language.functions import FUNCTIONS, HELPERS
from robosc.language.operators import BINARY, Result
from robosc.model.typing.compatibility import result_type
from robosc.plant.logic import conjunction, disjunction, negation
from robosc.plant.model_text import to_dsl
from robosc.plant.python_text import to_python
from robosc.runtime.core.operations import divide, remainder

ARITHMETIC = [o.spelling for o in BINARY.values() if o.result is not Result.BOOLEAN]
OF_ONE = ["abs", "sqrt", "sin", "cos", "floor", "ceil", "round"]
OF_TWO = ["min", "max", "hypot", "atan2"]
BOOL, INT, DOUBLE = BooleanType(), IntegerType(), DoubleType()
ROBOT = resolve("")
VALUES = {"p": True, "q": False, "i": 3, "j": -2, "x": 0.5, "huge": -(10**400)}
NUMBERS = st.sampled_from(
    [
        VariableRef("C", "i", INT),
        VariableRef("C", "j", IntegerType((-2, 3))),
        VariableRef("C", "x", DOUBLE),
        VariableRef("C", "huge", INT),
    ]
) | st.sampled_from([0, 1, -4, 2.5, -0.0]).map(
    lambda v: Literal(v, INT if isinstance(v, int) else DOUBLE)
)
BOOLEANS = st.sampled_from([TRUE, FALSE, VariableRef("C", "p", BOOL), VariableRef("C", "q", BOOL)])


def numbers(depth: int):
    if depth == 0:
        return NUMBERS
    below = numbers(depth - 1)
    return (
        NUMBERS
        | st.builds(lambda e: Unary("-", e, e.type), below)
        | st.builds(arithmetic, st.sampled_from(ARITHMETIC), below, below)
        | st.builds(lambda *parts: call(parts[0], parts[1:]), st.sampled_from(OF_ONE), below)
        | st.builds(lambda *parts: call(parts[0], parts[1:]), st.sampled_from(OF_TWO), below, below)
    )


def call(function, operands):
    type_ = result_type(FUNCTIONS[function].result, [operand.type for operand in operands])
    return Call(function, operands, type_)


def arithmetic(operator, left, right):
    type_ = result_type(BINARY[operator].result, (left.type, right.type))
    return Binary(operator, left, right, type_)


def booleans(depth: int):
    if depth == 0:
        return BOOLEANS
    below = booleans(depth - 1)
    return (
        BOOLEANS
        | st.builds(lambda e: Unary("!", e, BOOL), below)
        | st.builds(
            lambda o, a, b: Binary(o, a, b, BOOL),
            st.sampled_from(["and", "or", "=>", "=", "!="]),
            below,
            below,
        )
        | st.builds(
            lambda o, a, b: Binary(o, a, b, BOOL),
            st.sampled_from(["<", "<=", ">", ">=", "=", "!="]),
            numbers(depth - 1),
            numbers(depth - 1),
        )
    )


def lookup(leaf):
    return VALUES[leaf.variable]


@pytest.mark.slow
@settings(max_examples=500)
@given(booleans(4))
def test_python_text_means_the_expression(expr):
    source = to_python(expr, lambda leaf: f"v[{leaf.variable!r}]")
    assert eval(source, {**HELPERS, "v": VALUES}) is evaluate(expr, lookup)


@settings(max_examples=500)
@given(booleans(3))
def test_negation_is_the_opposite(expr):
    assert evaluate(negation(expr), lookup) is (not evaluate(expr, lookup))


@settings(max_examples=200)
@given(st.lists(booleans(2), max_size=4))
def test_chains_mean_all_and_any(parts):
    assert evaluate(conjunction(parts), lookup) is all(evaluate(p, lookup) for p in parts)
    assert evaluate(disjunction(parts), lookup) is any(evaluate(p, lookup) for p in parts)


def test_long_chains_are_low_trees():
    parts = [Binary("=", VariableRef("C", "i", INT), Literal(n, INT), BOOL) for n in range(5000)]
    assert evaluate(disjunction(parts), lookup) is True
    assert evaluate(disjunction(parts[4:]), lookup) is False
    assert to_dsl(disjunction(parts), ROBOT).count("or") == 4999
    assert conjunction(parts[:3]) == Binary("and", Binary("and", *parts[:2], BOOL), parts[2], BOOL)


def variable(name, type_=BOOL):
    return VariableRef("C", name, type_)


@pytest.mark.parametrize(
    ("expr", "text"),
    [
        (
            Binary("=>", Binary("=>", variable("p"), variable("q"), BOOL), variable("p"), BOOL),
            "(C.p => C.q) => C.p",
        ),
        (
            Binary("=>", variable("p"), Binary("=>", variable("q"), variable("p"), BOOL), BOOL),
            "C.p => C.q => C.p",
        ),
        (Unary("!", Binary("=", variable("p"), variable("q"), BOOL), BOOL), "!(C.p = C.q)"),
        (
            Binary(
                "-", variable("i", INT), Binary("-", Literal(1, INT), Literal(-2, INT), INT), INT
            ),
            "C.i - (1 - -2)",
        ),
        (Literal('a "b"\n\\', StringType()), '"a \\"b\\"\\n\\\\"'),
        (Literal(1e16, DOUBLE), "1E16"),
        (VariableRef("and", "value", BOOL), "^and.^value"),
        (ValueRef(("items", 0, "x"), INT), "value.items[0].x"),
    ],
)
def test_dsl_text_has_only_the_brackets_it_needs(expr, text):
    assert to_dsl(expr, ROBOT) == text


@pytest.mark.parametrize(
    ("left", "right", "rest"),
    [
        (7, 4, 3), (-1, 4, 3), (1, -4, -3), (-7, -4, -3), (5, 0, 5), (-5, 0, -5), (0, 0, 0),
        (-0.5, 2, 1.5), (5.5, -2.0, -0.5), (10**400, 7, 10**400 % 7), (2.0, 10**400, 2.0),
    ],
)  # fmt: skip
def test_a_remainder_has_the_sign_of_the_divisor(left, right, rest):
    found = remainder(left, right)
    assert (found, type(found)) == (rest, type(rest))


@pytest.mark.parametrize(
    ("left", "right"),
    [(5.0, 0), (5, 0.0), (0.0, 0), (math.inf, 2), (10**400, 2.5), (1.0, math.nan)],
)
def test_a_remainder_of_doubles_may_be_no_number(left, right):
    assert math.isnan(remainder(left, right))


def test_division_never_fails():
    assert divide(1, 0) == math.inf
    assert divide(-1, 0) == -math.inf
    assert divide(1, -0.0) == -math.inf
    assert math.isnan(divide(0, 0))
    assert math.isnan(divide(math.nan, 0))
    assert divide(7, 2) == 3.5
    assert divide(10**400, -3) == -math.inf
    assert divide(3, 10**400) == 0.0
    assert math.isnan(divide(10**400, 10**400))


def test_an_integer_beyond_the_doubles_is_an_infinity_beside_one():
    huge, half = variable("huge", INT), Literal(0.5, DOUBLE)
    assert evaluate(arithmetic("+", huge, half), lookup) == -math.inf
    assert evaluate(arithmetic("*", huge, half), lookup) == -math.inf
    assert evaluate(arithmetic("-", half, huge), lookup) == math.inf
    assert evaluate(arithmetic("-", huge, huge), lookup) == 0


@pytest.mark.parametrize(
    ("expr", "text"),
    [
        (arithmetic("+", variable("i", INT), Literal(0.5, DOUBLE)), "widen(i) + 0.5"),
        (
            arithmetic("+", variable("i", IntegerType((0, 9))), Literal(0.5, DOUBLE)),
            "i + 0.5",
        ),
        (arithmetic("*", variable("i", INT), Literal(2, INT)), "i * 2"),
        (arithmetic("*", variable("x", DOUBLE), variable("y", DOUBLE)), "x * y"),
    ],
)
def test_python_text_widens_only_what_may_be_too_large(expr, text):
    assert to_python(expr, lambda leaf: leaf.variable) == text


def test_undefined_parts_count_only_where_they_are_looked_at():
    missing = ValueRef(("items", 0), BOOL)

    def look(leaf):
        return None if isinstance(leaf, ValueRef) else VALUES[leaf.variable]

    assert evaluate(Binary("or", variable("p"), missing, BOOL), look) is True
    assert evaluate(Binary("and", variable("q"), missing, BOOL), look) is False
    assert evaluate(Binary("=>", variable("q"), missing, BOOL), look) is True
    with pytest.raises(Undefined):
        evaluate(Binary("or", variable("q"), missing, BOOL), look)
    with pytest.raises(Undefined):
        evaluate(Unary("!", missing, BOOL), look)
