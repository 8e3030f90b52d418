"""Expressions once the value that came in is known.

Where an event with a value becomes one event per value, guards and assignments no longer read
``value``: it is put in, and what has become constant is evaluated. An element that did not come
makes undefined what needs it; lazy operators need their right side only where the left does not
decide. So where a guard is true is an expression over the state again.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import NamedTuple, TypeAlias

from robosc.ir.formulas import conjunction, disjunction, junction, negation
from robosc.model.evaluation import evaluate
from robosc.model.expr import FALSE, TRUE, Expr, Holds, Leaf, Literal, Operation, ValueRef
from robosc.model.traversal import fold, with_operands
from robosc.model.types import BooleanType, Value

__all__ = ["PartValues", "assigned", "holds"]

PartValues: TypeAlias = Mapping[tuple[str | int, ...], Value | None]
"""What came in, by path; None: it did not."""


class _Truth(NamedTuple):
    """Where an expression is true, and where it is false; it is undefined elsewhere."""

    true: Expr
    false: Expr


_UNDEFINED = _Truth(FALSE, FALSE)


def holds(guard: Expr | None, values: PartValues) -> Expr:
    """Where a guard holds, as a condition over the state; TRUE without one."""
    return TRUE if guard is None else _truth(_partial(guard, values)).true


def assigned(expr: Expr, values: PartValues, old: Expr) -> Expr | None:
    """What an assignment gives to a variable that is ``old``; None if it leaves it as it is."""
    found = _partial(expr, values)
    if not isinstance(found, _Truth):
        return found
    if found == _UNDEFINED or not isinstance(expr.type, BooleanType):
        return None
    return disjunction([found.true, conjunction([negation(found.false), old])])


def _partial(expr: Expr, values: PartValues) -> Expr | _Truth:
    """The expression with the value put in, or where it is true and false if that may not be."""

    def leaf(node: Literal | Leaf) -> Expr | _Truth:
        if not isinstance(node, ValueRef):
            return node
        value = values[node.path]
        return _UNDEFINED if value is None else Literal(value, node.type)

    return fold(expr, leaf, _operation)


def _operation(node: Operation, operands: tuple[Expr | _Truth, ...]) -> Expr | _Truth:
    known = [part for part in operands if not isinstance(part, _Truth)]
    if len(known) == len(operands):
        return _evaluated(node, known)
    if isinstance(node, Holds):
        return _truth(operands[0]).true
    if not all(isinstance(e.type, BooleanType) for e in (node, node.operands[0])):
        return _UNDEFINED
    if len(operands) == 1:
        return _opposite(_truth(operands[0]))
    left, right = (_truth(part) for part in operands)
    if node.operation.is_lazy:
        return _lazy(node, left, right)
    return _same(left, right) if node.operator == "=" else _opposite(_same(left, right))


def _evaluated(node: Operation, operands: list[Expr]) -> Expr:
    found = with_operands(node, tuple(operands))
    if all(isinstance(part, Literal) for part in operands):
        return Literal(evaluate(found, lambda leaf: None), node.type)
    parts = junction(found, True)
    if parts is not None and any(isinstance(part, Literal) for part in operands):
        chain = conjunction if parts.conjunctive else disjunction
        return chain(part if keep else negation(part) for part, keep in parts.parts)
    return found


def _truth(part: Expr | _Truth) -> _Truth:
    return part if isinstance(part, _Truth) else _Truth(part, negation(part))


def _opposite(part: _Truth) -> _Truth:
    return _Truth(part.false, part.true)


def _lazy(node: Operation, left: _Truth, right: _Truth) -> _Truth:
    decided, open_ = left if node.operation.decider else _opposite(left)
    true, false = (conjunction([open_, side]) for side in right)
    if node.operation.decided:
        return _Truth(disjunction([decided, true]), false)
    return _Truth(true, disjunction([decided, false]))


def _same(left: _Truth, right: _Truth) -> _Truth:
    """Where two booleans are equal, and where they differ."""
    same = [conjunction([left[i], right[i]]) for i in (0, 1)]
    differ = [conjunction([left[i], right[1 - i]]) for i in (0, 1)]
    return _Truth(disjunction(same), disjunction(differ))
