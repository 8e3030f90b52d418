"""Partial evaluation of expressions for a known value of the event.

An event with a value is replaced by one event per value. In its guards and assignments ``value`` is
replaced, and constant subexpressions are evaluated. An expression that needs a missing array
element is undefined; lazy operators need their right operand only where the left one does not
decide. The result is an expression over the state: where the guard is true.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import NamedTuple, TypeAlias

from robosc.expr import evaluation, traversal, types
from robosc.expr.tree import FALSE, TRUE, Expr, Holds, Leaf, Literal, Operation, ValueRef
from robosc.plant import logic

PartValues: TypeAlias = Mapping[tuple[str | int, ...], types.Value | None]
"""The parts of the value, by path; None: the part is missing."""


class _Truth(NamedTuple):
    """The conditions under which an expression is true and false; elsewhere it is undefined."""

    true: Expr
    false: Expr


_UNDEFINED = _Truth(FALSE, FALSE)


def holds(guard: Expr | None, values: PartValues) -> Expr:
    """Return the condition over the state under which a guard holds; TRUE without a guard."""
    return TRUE if guard is None else _truth(_partial(guard, values)).true


def assigned(expr: Expr, values: PartValues, old: Expr) -> Expr | None:
    """Return the value after an assignment to a variable that is ``old``; None if it is
    unchanged."""
    found = _partial(expr, values)
    if not isinstance(found, _Truth):
        return found
    if found == _UNDEFINED or not isinstance(expr.type, types.BooleanType):
        return None
    return logic.disjunction([found.true, logic.conjunction([logic.negation(found.false), old])])


def _partial(expr: Expr, values: PartValues) -> Expr | _Truth:
    """Return the expression for this value, or its truth conditions if it may be undefined."""

    def leaf(node: Literal | Leaf) -> Expr | _Truth:
        if not isinstance(node, ValueRef):
            return node
        value = values[node.path]
        return _UNDEFINED if value is None else Literal(value, node.type)

    return traversal.fold(expr, leaf, _operation)


def _operation(node: Operation, operands: tuple[Expr | _Truth, ...]) -> Expr | _Truth:
    if isinstance(node, Holds):
        is_condition = isinstance(node.operand.type, types.BooleanType)
        return _truth(operands[0]).true if is_condition else _is_there(operands[0])
    known = [part for part in operands if not isinstance(part, _Truth)]
    if len(known) == len(operands):
        return _evaluated(node, known)
    if node.operator == "else":  # of finite values: what is defined is a number
        return operands[1] if isinstance(operands[0], _Truth) else operands[0]
    if not all(isinstance(e.type, types.BooleanType) for e in (node, node.operands[0])):
        return _UNDEFINED
    if len(operands) == 1:
        return _opposite(_truth(operands[0]))
    left, right = (_truth(part) for part in operands)
    if node.operation.is_lazy:
        return _lazy(node, left, right)
    return _same(left, right) if node.operator == "=" else _opposite(_same(left, right))


def _evaluated(node: Operation, operands: list[Expr]) -> Expr:
    found = traversal.with_operands(node, tuple(operands))
    if all(isinstance(part, Literal) for part in operands):
        return Literal(evaluation.evaluate(found, lambda leaf: None), node.type)
    parts = logic.junction(found, True)
    if parts is not None and any(isinstance(part, Literal) for part in operands):
        chain = logic.conjunction if parts.conjunctive else logic.disjunction
        return chain(part if keep else logic.negation(part) for part, keep in parts.parts)
    return found


def _truth(part: Expr | _Truth) -> _Truth:
    return part if isinstance(part, _Truth) else _Truth(part, logic.negation(part))


def _is_there(part: Expr | _Truth) -> Expr:
    return FALSE if isinstance(part, _Truth) else TRUE


def _opposite(part: _Truth) -> _Truth:
    return _Truth(part.false, part.true)


def _lazy(node: Operation, left: _Truth, right: _Truth) -> _Truth:
    decided, open_ = left if node.operation.decider else _opposite(left)
    true, false = (logic.conjunction([open_, side]) for side in right)
    if node.operation.decided:
        return _Truth(logic.disjunction([decided, true]), false)
    return _Truth(true, logic.disjunction([decided, false]))


def _same(left: _Truth, right: _Truth) -> _Truth:
    """Return where two booleans are equal, and where they differ."""
    same = [logic.conjunction([left[i], right[i]]) for i in (0, 1)]
    differ = [logic.conjunction([left[i], right[1 - i]]) for i in (0, 1)]
    return _Truth(logic.disjunction(same), logic.disjunction(differ))
