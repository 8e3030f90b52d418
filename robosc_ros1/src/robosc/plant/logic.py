"""Conditions joined, negated and simplified."""

from __future__ import annotations

from collections.abc import Iterable
from typing import NamedTuple

from robosc.expr import quantified, traversal, tree, types
from robosc.expr.identity_cache import IdentityCache

_BOOLEAN = types.BooleanType()


def negation(expr: tree.Expr) -> tree.Expr:
    """Return ``!expr``; for a comparison, the opposite comparison."""
    if isinstance(expr, tree.Binary) and expr.operation.negation:
        return tree.Binary(expr.operation.negation, expr.left, expr.right, _BOOLEAN)
    return quantified.opposite(expr)


def conjunction(parts: Iterable[tree.Expr]) -> tree.Expr:
    """Return the conjunction without repeated and constant parts; TRUE if none is left."""
    return _simplified("and", parts, tree.TRUE, tree.FALSE)


def disjunction(parts: Iterable[tree.Expr]) -> tree.Expr:
    """Return the disjunction without repeated and constant parts; FALSE if none is left."""
    return _simplified("or", parts, tree.FALSE, tree.TRUE)


def _simplified(
    operator: str, parts: Iterable[tree.Expr], unit: tree.Literal, zero: tree.Literal
) -> tree.Expr:
    distinct = [*parts]
    if len(distinct) > 1:  # hashing traverses expressions, which may be large
        distinct = [*dict.fromkeys(distinct)]
    kept = [p for p in distinct if p != unit]
    if zero in kept:
        return zero
    return quantified.chain(operator, kept) if kept else unit


class Junction(NamedTuple):
    """A conjunction or disjunction of two expressions with their polarity (False: negated)."""

    conjunctive: bool
    parts: tuple[tuple[tree.Expr, bool], tuple[tree.Expr, bool]]


def junction(expr: tree.Expr, polarity: bool) -> Junction | None:
    """Return the operands of an ``and``, ``or`` or ``=>``, or (``polarity`` False) of its negation.

    None for any other expression.
    """
    if not isinstance(expr, tree.Binary) or expr.operation.decider is None:
        return None
    operation = expr.operation
    conjunctive = polarity != operation.decided
    left = operation.decider != conjunctive
    return Junction(conjunctive, ((expr.left, left), (expr.right, polarity)))


def exact(expr: tree.Expr) -> tree.Expr:
    """Return the expression with the terms of the plant replaced by the data that they test."""

    def leaf(node: tree.Literal | tree.Leaf) -> tree.Expr:
        test = _test(node)
        return node if test is None else test.subject

    def operation(node: tree.Operation, operands: tuple[tree.Expr, ...]) -> tree.Expr:
        test = _test(node.left) if isinstance(node, tree.Binary) else None
        if test is None or test.other is None:
            return traversal.with_operands(node, operands)
        return tree.Binary(node.operator, test.subject, test.other, node.type, node.span)

    return traversal.fold(expr, leaf, operation)


def _test(expr: tree.Expr) -> tree.TestRef | None:
    match expr:
        case tree.TestRef():
            return expr
        case tree.ChoiceRef(test=test):
            return test
    return None


def simplified(expr: tree.Expr) -> tree.Expr:
    """Return a condition without constant operands of ``and``, ``or``, ``=>`` and ``!``; parts that
    it shares stay shared."""
    known: IdentityCache[tree.Expr] = IdentityCache()

    def without(expr: tree.Expr) -> tree.Expr:
        if isinstance(expr, tree.Unary) and expr.operator == "!":
            return negation(known.of(expr.operand, without))
        found = junction(expr, True)
        if found is None:
            return expr
        conjunctive, parts = found
        sides = [known.of(part, without) for part, _ in parts]
        sides = [
            side if polarity else negation(side)
            for side, (_, polarity) in zip(sides, parts, strict=True)
        ]
        return conjunction(sides) if conjunctive else disjunction(sides)

    return without(expr)
