"""Partial evaluation: an expression once the value that came in is known.

Where an event with a value becomes one event per value, guards and assignments no longer read
``value``: it is put in, and what has become constant is folded. An element that did not come
(LANGUAGE section 5) makes undefined what needs it; ``and``, ``or`` and ``=>`` need their right side
only where the left does not decide.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import TypeAlias

from robosc.ir.expr import Undefined, conjunction, disjunction, evaluate, negation
from robosc.model.expr import FALSE, TRUE, Binary, Expr, Literal, Unary, ValueRef, VariableRef, walk
from robosc.model.types import BooleanType, Value

__all__ = ["Values", "assigned", "holds"]

Values: TypeAlias = Mapping[tuple[str | int, ...], Value | None]


def assigned(expr: Expr, values: Values, kept: VariableRef) -> Expr | None:
    """What an assignment to the variable ``kept`` gives it; None if it leaves it as it is."""
    try:
        return put_in(expr, values)
    except Undefined:
        if not isinstance(expr.type, BooleanType):
            return None
    true, false = truth(expr, values)
    return disjunction([true, conjunction([negation(false), kept])])


def holds(guard: Expr | None, values: Values) -> Expr:
    """Where a guard holds, as a condition over the state; TRUE without one."""
    return TRUE if guard is None else truth(guard, values)[0]


def put_in(expr: Expr, values: Values) -> Expr:
    """The expression with the value put in.

    Raises:
        Undefined: it reads an element that did not come.
    """
    match expr:
        case ValueRef(path=path, type=type_):
            value = values[path]
            if value is None:
                raise Undefined
            return Literal(value, type_)
        case Unary(operator=operator, operand=operand):
            return _folded(Unary(operator, put_in(operand, values), expr.type))
        case Binary(operator=operator, left=left, right=right):
            sides = put_in(left, values), put_in(right, values)
            return _folded(Binary(operator, *sides, expr.type))
    return expr


def _folded(expr: Unary | Binary) -> Expr:
    parts = [expr.operand] if isinstance(expr, Unary) else [expr.left, expr.right]
    if all(isinstance(part, Literal) for part in parts):
        return Literal(evaluate(expr, lambda leaf: None), expr.type)
    if isinstance(expr, Binary):
        match expr.operator:
            case "and":
                return conjunction(parts)
            case "or":
                return disjunction(parts)
            case "=>" if TRUE in parts or parts[0] == FALSE:
                return expr.right if expr.left == TRUE else TRUE
    return expr


def truth(expr: Expr, values: Values) -> tuple[Expr, Expr]:
    """Where a boolean expression is true, and where it is false; it is undefined elsewhere."""
    missing = any(isinstance(p, ValueRef) and values[p.path] is None for p in walk(expr))
    if not missing:
        known = put_in(expr, values)
        return known, negation(known)
    match expr:
        case Unary(operator="!", operand=operand):
            true, false = truth(operand, values)
            return false, true
        case Binary(operator="and" | "or" | "=>" as operator, left=left, right=right):
            return _decided(operator, truth(left, values), truth(right, values))
        case Binary(operator=operator, left=left, right=right):
            if isinstance(left.type, BooleanType):
                return _equal(operator, truth(left, values), truth(right, values))
    return FALSE, FALSE


_Truth: TypeAlias = tuple[Expr, Expr]


def _decided(operator: str, left: _Truth, right: _Truth) -> _Truth:
    if operator == "and":
        return conjunction([left[0], right[0]]), _either(left[1], left[0], right[1])
    if operator == "or":
        return _either(left[0], left[1], right[0]), conjunction([left[1], right[1]])
    return _either(left[1], left[0], right[0]), conjunction([left[0], right[1]])


def _either(first: Expr, otherwise: Expr, second: Expr) -> Expr:
    return disjunction([first, conjunction([otherwise, second])])


def _equal(operator: str, left: _Truth, right: _Truth) -> _Truth:
    same = [conjunction([left[i], right[i]]) for i in (0, 1)]
    differ = [conjunction([left[i], right[1 - i]]) for i in (0, 1)]
    pair = disjunction(same), disjunction(differ)
    return pair if operator == "=" else (pair[1], pair[0])
