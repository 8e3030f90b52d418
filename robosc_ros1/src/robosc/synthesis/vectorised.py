"""Expressions evaluated over many states at once.

An expression over a few axes is evaluated for all their values in one go: each axis is a *column*,
an array of indexes into its values, shaped so that numpy broadcasts columns against each other.
Results equal :func:`robosc.ir.expr.evaluate` exactly: integers never overflow and never pass
through a double that cannot hold them (Python's own integers take over where 64 bits might not do),
and division is that of IEEE 754.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, TypeAlias

import numpy as np
from numpy.typing import NDArray

from robosc.ir.automaton import Axis, AxisKind, Plant
from robosc.ir.expr import OPERATIONS
from robosc.model.expr import (
    Binary,
    Expr,
    Literal,
    PhaseRef,
    StateRef,
    Unary,
    ValueRef,
    VariableRef,
    walk,
)
from robosc.model.types import EnumType, StringType, Type

__all__ = ["Bools", "IndexArrays", "Indexes", "axis_of", "evaluate_vectorised", "support"]

Bools: TypeAlias = NDArray[np.bool_]
Indexes: TypeAlias = NDArray[np.intp]
IndexArrays: TypeAlias = Mapping[int, Indexes]
"""Index arrays by axis, broadcastable against each other."""

_EXACT_IN_DOUBLE = 2**53
_EXACT_IN_INT64 = 2**62
_COMPARISONS = frozenset({"=", "!=", "<", "<=", ">", ">="})


def axis_of(plant: Plant, leaf: Expr) -> int | None:
    """The axis that a leaf reads; None for all that reads no state."""
    match leaf:
        case VariableRef(component=component, variable=name):
            return plant.axis_index[AxisKind.VARIABLE, f"{component}.{name}"]
        case StateRef(component=component):
            return plant.axis_index[AxisKind.LOCATION, component]
        case PhaseRef(communication=key):
            return plant.axis_index[AxisKind.PHASE, key]
    return None


def support(plant: Plant, expr: Expr) -> tuple[int, ...]:
    """The axes that an expression reads, ascending."""
    found = {axis for node in walk(expr) if (axis := axis_of(plant, node)) is not None}
    return tuple(sorted(found))


def evaluate_vectorised(plant: Plant, expr: Expr, columns: IndexArrays) -> NDArray[Any]:
    """The expression for all combinations of the columns.

    The result broadcasts against the columns; it need not have their full shape. Values of enums
    are their index in the type. The expression holds no ``value``: parameters are put in before.
    """
    match expr:
        case Literal(value=value, type=type_):
            return _literal(value, type_)
        case Unary(operator="!", operand=operand):
            return np.asarray(np.logical_not(evaluate_vectorised(plant, operand, columns)))
        case Unary(operand=operand):
            return np.asarray(np.negative(evaluate_vectorised(plant, operand, columns)))
        case Binary(operator=op, left=left, right=right):
            first = evaluate_vectorised(plant, left, columns)
            second = evaluate_vectorised(plant, right, columns)
            return _apply(op, first, second)
        case ValueRef():
            raise AssertionError("a parameter without value")
    axis = axis_of(plant, expr)
    assert axis is not None
    return _leaf(plant.axes[axis], expr, columns[axis])


def _leaf(axis: Axis, expr: Expr, indexes: Indexes) -> NDArray[Any]:
    match expr:
        case StateRef(state=name):
            result: NDArray[Any] = indexes == axis.values.index(name)
            return result
        case PhaseRef():
            return np.asarray(indexes == 1)
        case VariableRef(type=EnumType(values=names)):
            codes = [names.index(str(v)) for v in axis.values]
            return np.array(codes, dtype=np.int64)[indexes]
    values = axis.values
    if isinstance(values, range):
        fits = max(abs(values[0]), abs(values[-1])) < _EXACT_IN_INT64
        return np.asarray(indexes.astype(np.int64 if fits else object) + values[0])
    return np.array(values, dtype=np.bool_)[indexes]


def _literal(value: object, type_: Type) -> NDArray[Any]:
    if isinstance(type_, EnumType):
        return np.array(type_.values.index(str(value)), dtype=np.int64)
    if isinstance(value, int) and not isinstance(value, bool) and abs(value) >= _EXACT_IN_INT64:
        return np.array(value, dtype=object)
    return np.array(value, dtype=object if isinstance(type_, StringType) else None)


def _apply(op: str, left: NDArray[Any], right: NDArray[Any]) -> NDArray[Any]:
    match op:
        case "and":
            return np.asarray(np.logical_and(left, right))
        case "or":
            return np.asarray(np.logical_or(left, right))
        case "=>":
            return np.asarray(np.logical_or(np.logical_not(left), right))
    if not _exact(op, left, right):
        outcome = np.frompyfunc(OPERATIONS[op], 2, 1)(left.astype(object), right.astype(object))
        return np.asarray(outcome, dtype=np.bool_ if op in _COMPARISONS else object)
    if op == "/":
        with np.errstate(all="ignore"):
            return np.asarray(np.true_divide(left, right))
    with np.errstate(all="ignore"):
        return np.asarray(OPERATIONS[op](left, right))


def _exact(op: str, left: NDArray[Any], right: NDArray[Any]) -> bool:
    """Whether numpy's own arithmetic cannot differ from Python's."""
    kinds = left.dtype.kind + right.dtype.kind
    if "O" in kinds:
        return False
    if kinds == "ii":
        if op == "/":
            return max(_magnitude(left), _magnitude(right)) <= _EXACT_IN_DOUBLE
        if op in _COMPARISONS:
            return True
        return _bound(op, _magnitude(left), _magnitude(right)) < _EXACT_IN_INT64
    integers = [side for side in (left, right) if side.dtype.kind == "i"]
    return all(_magnitude(side) <= _EXACT_IN_DOUBLE for side in integers)


def _bound(op: str, left: int, right: int) -> int:
    return left * right if op == "*" else left + right


def _magnitude(values: NDArray[Any]) -> int:
    return max(abs(int(values.min())), abs(int(values.max()))) if values.size else 0
