"""Conditions joined, negated and simplified."""

from __future__ import annotations

from collections.abc import Iterable
from typing import NamedTuple

from robosc.expr.quantified import chain, opposite
from robosc.expr.traversal import fold, with_operands
from robosc.expr.tree import (
    FALSE,
    TRUE,
    Binary,
    ChoiceRef,
    Expr,
    Leaf,
    Literal,
    Operation,
    TestRef,
    Unary,
)
from robosc.expr.types import BooleanType

_BOOLEAN = BooleanType()


def negation(expr: Expr) -> Expr:
    """Return ``!expr``; for a comparison, the opposite comparison."""
    if isinstance(expr, Binary) and expr.operation.negation:
        return Binary(expr.operation.negation, expr.left, expr.right, _BOOLEAN)
    return opposite(expr)


def conjunction(parts: Iterable[Expr]) -> Expr:
    """Return the conjunction without repeated and constant parts; TRUE if none is left."""
    return _simplified("and", parts, TRUE, FALSE)


def disjunction(parts: Iterable[Expr]) -> Expr:
    """Return the disjunction without repeated and constant parts; FALSE if none is left."""
    return _simplified("or", parts, FALSE, TRUE)


def _simplified(operator: str, parts: Iterable[Expr], unit: Literal, zero: Literal) -> Expr:
    distinct = [*parts]
    if len(distinct) > 1:  # hashing traverses expressions, which may be large
        distinct = [*dict.fromkeys(distinct)]
    kept = [p for p in distinct if p != unit]
    if zero in kept:
        return zero
    return chain(operator, kept) if kept else unit


class Junction(NamedTuple):
    """A conjunction or disjunction of two expressions with their polarity (False: negated)."""

    conjunctive: bool
    parts: tuple[tuple[Expr, bool], tuple[Expr, bool]]


def junction(expr: Expr, polarity: bool) -> Junction | None:
    """Return the operands of an ``and``, ``or`` or ``=>``, or (``polarity`` False) of its negation.

    None for any other expression.
    """
    if not isinstance(expr, Binary) or expr.operation.decider is None:
        return None
    operation = expr.operation
    conjunctive = polarity != operation.decided
    left = operation.decider != conjunctive
    return Junction(conjunctive, ((expr.left, left), (expr.right, polarity)))


def exact(expr: Expr) -> Expr:
    """Return the expression with the terms of the plant replaced by the data that they test."""

    def leaf(node: Literal | Leaf) -> Expr:
        test = _test(node)
        return node if test is None else test.subject

    def operation(node: Operation, operands: tuple[Expr, ...]) -> Expr:
        test = _test(node.left) if isinstance(node, Binary) else None
        if test is None or test.other is None:
            return with_operands(node, operands)
        return Binary(node.operator, test.subject, test.other, node.type, node.span)

    return fold(expr, leaf, operation)


def _test(expr: Expr) -> TestRef | None:
    match expr:
        case TestRef():
            return expr
        case ChoiceRef(test=test):
            return test
    return None


def simplified(expr: Expr) -> Expr:
    """Return a condition without constant operands of ``and``, ``or``, ``=>`` and ``!``."""
    if isinstance(expr, Unary) and expr.operator == "!":
        return negation(simplified(expr.operand))
    found = junction(expr, True)
    if found is None or not isinstance(expr, Binary):
        return expr
    conjunctive, parts = found
    sides = [
        simplified(part) if polarity else negation(simplified(part)) for part, polarity in parts
    ]
    return conjunction(sides) if conjunctive else disjunction(sides)
