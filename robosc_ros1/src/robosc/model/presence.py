"""Conditions over data that may not be there: objects and arrays that no message has brought yet.

A condition that is undefined does not hold. Where one reads such data, this is spelled out at its
comparisons, so that all later stages have a condition that is always true or false.
"""

from __future__ import annotations

from robosc.language.operators import BINARY
from robosc.model.expr import Binary, Expr, Holds, Unary, VariableRef
from robosc.model.traversal import may_be_undefined, walk
from robosc.model.types import ArrayType, BooleanType, ObjectType

__all__ = ["condition_on_data"]

_BOOLEAN = BooleanType()


def condition_on_data(expr: Expr) -> Expr:
    """The condition; True just where the given one is defined and true."""
    reads_whole = any(
        isinstance(part, VariableRef) and isinstance(part.type, ArrayType | ObjectType)
        for part in walk(expr)
    )
    return _truth(expr, True) if reads_whole else expr


def _truth(expr: Expr, wanted: bool) -> Expr:
    """That an expression is defined, and true (``wanted``) or false."""
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
    """For an operator that looks at its right side only where the left does not decide."""
    operation = BINARY[expr.operator]
    assert operation.decider is not None
    by_right = Binary(
        "and", _truth(left, not operation.decider), _truth(right, wanted), _BOOLEAN, expr.span
    )
    if operation.decided is not wanted:
        return by_right
    by_left = _truth(left, operation.decider)
    return Binary("or", by_left, by_right, _BOOLEAN, expr.span)
