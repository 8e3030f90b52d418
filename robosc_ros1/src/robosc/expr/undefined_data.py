"""Conditions over data that may be absent: objects and arrays before the first message.

An undefined condition does not hold. Where a condition reads such data, ``Holds`` is inserted
around its comparisons, so that later stages have conditions that are either true or false.
"""

from __future__ import annotations

from collections.abc import Container, Iterable, Iterator
from dataclasses import replace
from functools import reduce

from robosc.expr.identity_cache import IdentityCache
from robosc.expr.traversal import fold, may_be_undefined, operands, with_operands
from robosc.expr.tree import (
    TRUE,
    Aggregate,
    Binary,
    Expr,
    Holds,
    Leaf,
    Literal,
    Operation,
    ParameterRef,
    Unary,
    VariableRef,
)
from robosc.expr.types import ArrayType, BooleanType, ObjectType
from robosc.language.operators import BINARY
from robosc.source import Span

_BOOLEAN = BooleanType()


def condition_on_data(expr: Expr, known: IdentityCache[bool] | None = None) -> Expr:
    """A condition without undefined values: true where the given one is defined and true.

    ``known`` keeps which parts read stored data, for conditions that share large parts.
    """
    return _truth(expr, True) if _reads_stored(expr, known or IdentityCache()) else expr


def _reads_stored(expr: Expr, known: IdentityCache[bool]) -> bool:
    """Whether an expression reads an array or an object of a variable or a constant."""

    def leaf(node: Literal | Leaf) -> bool:
        stored = isinstance(node, VariableRef | Literal | ParameterRef)
        return stored and isinstance(node.type, ArrayType | ObjectType)

    def strict(node: Operation, operands: tuple[bool, ...]) -> bool:
        return known.of(node, lambda _: any(operands))

    return fold(expr, leaf, strict, known=known.known)


def _truth(expr: Expr, wanted: bool) -> Expr:
    """The condition that an expression is defined, and its value is ``wanted``."""
    if not may_be_undefined(expr):
        return expr if wanted else Unary("!", expr, _BOOLEAN, expr.span)
    match expr:
        case Unary(operator="!", operand=operand):
            return _truth(operand, not wanted)
        case Binary(left=left, right=right) if expr.operation.is_lazy:
            return _decided(expr, left, right, wanted)
    kept = expr if wanted else Unary("!", expr, _BOOLEAN, expr.span)
    return Holds(kept, expr.span)


def _decided(expr: Binary, left: Expr, right: Expr, wanted: bool) -> Expr:
    """:func:`_truth` for an operator that evaluates its right side only if the left is open."""
    operation = BINARY[expr.operator]
    assert operation.decider is not None
    by_right = Binary(
        "and", _truth(left, not operation.decider), _truth(right, wanted), _BOOLEAN, expr.span
    )
    if operation.decided is not wanted:
        return by_right
    by_left = _truth(left, operation.decider)
    return Binary("or", by_left, by_right, _BOOLEAN, expr.span)


def known_condition(expr: Expr) -> Expr:
    """A condition that is defined and true where the given one is, and false elsewhere."""
    return _truth(expr, True)


def none_of(conditions: Iterable[Expr], span: Span) -> Expr:
    """The condition that none of the conditions holds, each of which is always defined."""
    parts: Iterator[Expr] = (Unary("!", condition, _BOOLEAN, span) for condition in conditions)
    return reduce(lambda left, right: Binary("and", left, right, _BOOLEAN, span), parts)


def otherwise(condition: Expr, alternative: Expr, span: Span) -> Expr:
    """``condition else alternative``, in terms of which outcomes are defined."""
    if not may_be_undefined(condition):
        return condition
    false = Holds(Unary("!", condition, _BOOLEAN, span), span)
    missing = Unary("!", false, _BOOLEAN, span)
    by_alternative = Binary("and", missing, alternative, _BOOLEAN, span)
    return Binary("or", Holds(condition, span), by_alternative, _BOOLEAN, span)


# --- as text of the language ---------------------------------------------------------------------


def defined(expr: Expr) -> Literal | Holds:
    """``defined(…)``: the condition that an expression is defined."""
    if not may_be_undefined(expr):
        return TRUE
    if isinstance(expr.type, BooleanType):
        expr = Binary("or", expr, TRUE, _BOOLEAN)
    return Holds(expr)


def asked_for(expr: Holds) -> Expr:
    """The operand of ``defined(…)`` as the user wrote it."""
    operand = expr.operand
    return operand.left if isinstance(operand, Binary) and operand.right == TRUE else operand


def with_presence_written(expr: Expr, undefined_is_false: bool = True) -> Expr:
    """The condition as the language writes it: without ``Holds`` around conditions.

    Where an undefined condition counts as false (``undefined_is_false``), as in a whole
    requirement, the operand of ``Holds`` is written alone, elsewhere together with ``defined(…)``.
    """
    match expr:
        case Binary(operator=operator, left=left, right=right) if expr.operation.is_lazy:
            kept = undefined_is_false and operator == "and"
            left = with_presence_written(left, kept)
            right = with_presence_written(right, undefined_is_false)
            if operator == "and":
                known = [part for part in operands(left, "and") if isinstance(part, Holds)]
                right = _without(right, known)
                if right == TRUE:
                    return left
            return replace(expr, left=left, right=right)
        case Holds(operand=operand) if operand == asked_for(expr) and operand.type == _BOOLEAN:
            condition = with_presence_written(operand, False)
            there = TRUE if undefined_is_false else defined(_needed(operand))
            return condition if there == TRUE else Binary("and", there, condition, _BOOLEAN)
    if isinstance(expr, Operation):
        parts = tuple(with_presence_written(part, False) for part in expr.operands)
        return with_operands(expr, parts)
    return expr


def _without(expr: Expr, known: Container[Expr]) -> Expr:
    """The conjunction without the operands that are known to hold."""
    if not (isinstance(expr, Binary) and expr.operator == "and"):
        return TRUE if expr in known else expr
    left, right = _without(expr.left, known), _without(expr.right, known)
    if TRUE in (left, right):
        return right if left == TRUE else left
    return replace(expr, left=left, right=right)


def _needed(condition: Expr) -> Expr:
    """The only part of a condition that may be undefined; the condition itself if several may."""
    match condition:
        case Unary(operand=operand):
            return _needed(operand)
        case Aggregate(operator="any" | "all" | "count" | "sum", array=array):
            return _needed(array)  # an element for which it is undefined does not count
        case Binary(operator="else"):
            return condition
        case Binary(left=left, right=right) if not condition.operation.is_lazy:
            sides = [side for side in (left, right) if may_be_undefined(side)]
            return _needed(sides[0]) if len(sides) == 1 else condition
    return condition
