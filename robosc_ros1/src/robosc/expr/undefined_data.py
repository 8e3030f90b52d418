"""Conditions over data that may be absent: objects and arrays before the first message.

An undefined condition does not hold. Where a condition reads such data, ``Holds`` is inserted
around its comparisons, so that later stages have conditions that are either true or false.
"""

from __future__ import annotations

from collections.abc import Container, Iterable, Iterator
from dataclasses import replace
from functools import reduce

from robosc.expr import tree, types
from robosc.expr.identity_cache import IdentityCache
from robosc.expr.traversal import fold, may_be_undefined, operands, with_operands
from robosc.language.operators import BINARY
from robosc.source import Span

_BOOLEAN = types.BooleanType()


def condition_on_data(expr: tree.Expr, known: IdentityCache[bool] | None = None) -> tree.Expr:
    """A condition without undefined values: true where the given one is defined and true.

    ``known`` keeps which parts read stored data, for conditions that share large parts.
    """
    return _truth(expr, True) if _reads_stored(expr, known or IdentityCache()) else expr


def _reads_stored(expr: tree.Expr, known: IdentityCache[bool]) -> bool:
    """Whether an expression reads an array or an object of a variable or a constant."""

    def leaf(node: tree.Literal | tree.Leaf) -> bool:
        stored = isinstance(node, tree.VariableRef | tree.Literal | tree.ParameterRef)
        return stored and isinstance(node.type, types.ArrayType | types.ObjectType)

    def strict(node: tree.Operation, operands: tuple[bool, ...]) -> bool:
        return known.of(node, lambda _: any(operands))

    return fold(expr, leaf, strict, known=known.known)


def _truth(expr: tree.Expr, wanted: bool) -> tree.Expr:
    """The condition that an expression is defined, and its value is ``wanted``."""
    if not may_be_undefined(expr):
        return expr if wanted else tree.Unary("!", expr, _BOOLEAN, expr.span)
    match expr:
        case tree.Unary(operator="!", operand=operand):
            return _truth(operand, not wanted)
        case tree.Binary(left=left, right=right) if expr.operation.is_lazy:
            return _decided(expr, left, right, wanted)
    kept = expr if wanted else tree.Unary("!", expr, _BOOLEAN, expr.span)
    return tree.Holds(kept, expr.span)


def _decided(expr: tree.Binary, left: tree.Expr, right: tree.Expr, wanted: bool) -> tree.Expr:
    """:func:`_truth` for an operator that evaluates its right side only if the left is open."""
    operation = BINARY[expr.operator]
    assert operation.decider is not None
    by_right = tree.Binary(
        "and", _truth(left, not operation.decider), _truth(right, wanted), _BOOLEAN, expr.span
    )
    if operation.decided is not wanted:
        return by_right
    by_left = _truth(left, operation.decider)
    return tree.Binary("or", by_left, by_right, _BOOLEAN, expr.span)


def known_condition(expr: tree.Expr) -> tree.Expr:
    """A condition that is defined and true where the given one is, and false elsewhere."""
    return _truth(expr, True)


def none_of(conditions: Iterable[tree.Expr], span: Span) -> tree.Expr:
    """The condition that none of the conditions holds, each of which is always defined."""
    parts: Iterator[tree.Expr] = (
        tree.Unary("!", condition, _BOOLEAN, span) for condition in conditions
    )
    return reduce(lambda left, right: tree.Binary("and", left, right, _BOOLEAN, span), parts)


def otherwise(condition: tree.Expr, alternative: tree.Expr, span: Span) -> tree.Expr:
    """``condition else alternative``, in terms of which outcomes are defined."""
    if not may_be_undefined(condition):
        return condition
    false = tree.Holds(tree.Unary("!", condition, _BOOLEAN, span), span)
    missing = tree.Unary("!", false, _BOOLEAN, span)
    by_alternative = tree.Binary("and", missing, alternative, _BOOLEAN, span)
    return tree.Binary("or", tree.Holds(condition, span), by_alternative, _BOOLEAN, span)


# --- as text of the language ---------------------------------------------------------------------


def defined(expr: tree.Expr) -> tree.Literal | tree.Holds:
    """``defined(…)``: the condition that an expression is defined."""
    if not may_be_undefined(expr):
        return tree.TRUE
    if isinstance(expr.type, types.BooleanType):
        expr = tree.Binary("or", expr, tree.TRUE, _BOOLEAN)
    return tree.Holds(expr)


def asked_for(expr: tree.Holds) -> tree.Expr:
    """The operand of ``defined(…)`` as the user wrote it."""
    operand = expr.operand
    return (
        operand.left if isinstance(operand, tree.Binary) and operand.right == tree.TRUE else operand
    )


def with_presence_written(expr: tree.Expr, undefined_is_false: bool = True) -> tree.Expr:
    """The condition as the language writes it: without ``Holds`` around conditions.

    Where an undefined condition counts as false (``undefined_is_false``), as in a whole
    requirement, the operand of ``Holds`` is written alone, elsewhere together with ``defined(…)``.
    """
    match expr:
        case tree.Binary(operator=operator, left=left, right=right) if expr.operation.is_lazy:
            kept = undefined_is_false and operator == "and"
            left = with_presence_written(left, kept)
            right = with_presence_written(right, undefined_is_false)
            if operator == "and":
                known = [part for part in operands(left, "and") if isinstance(part, tree.Holds)]
                right = _without(right, known)
                if right == tree.TRUE:
                    return left
            return replace(expr, left=left, right=right)
        case tree.Holds(operand=operand) if operand == asked_for(expr) and operand.type == _BOOLEAN:
            condition = with_presence_written(operand, False)
            there = tree.TRUE if undefined_is_false else defined(_needed(operand))
            return (
                condition if there == tree.TRUE else tree.Binary("and", there, condition, _BOOLEAN)
            )
    if isinstance(expr, tree.Operation):
        parts = tuple(with_presence_written(part, False) for part in expr.operands)
        return with_operands(expr, parts)
    return expr


def _without(expr: tree.Expr, known: Container[tree.Expr]) -> tree.Expr:
    """The conjunction without the operands that are known to hold."""
    if not (isinstance(expr, tree.Binary) and expr.operator == "and"):
        return tree.TRUE if expr in known else expr
    left, right = _without(expr.left, known), _without(expr.right, known)
    if tree.TRUE in (left, right):
        return right if left == tree.TRUE else left
    return replace(expr, left=left, right=right)


def _needed(condition: tree.Expr) -> tree.Expr:
    """The only part of a condition that may be undefined; the condition itself if several may."""
    match condition:
        case tree.Unary(operand=operand):
            return _needed(operand)
        case tree.Aggregate(operator="any" | "all" | "count" | "sum", array=array):
            return _needed(array)  # an element for which it is undefined does not count
        case tree.Binary(operator="else"):
            return condition
        case tree.Binary(left=left, right=right) if not condition.operation.is_lazy:
            sides = [side for side in (left, right) if may_be_undefined(side)]
            return _needed(sides[0]) if len(sides) == 1 else condition
    return condition
