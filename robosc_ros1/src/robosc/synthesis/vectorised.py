"""Vectorised evaluation of expressions over many states at once.

An expression over a few state variables is evaluated for all their values in one call: each state
variable is a *column*, an array of indexes into its values, shaped so that numpy broadcasts columns
against each other. Results equal :func:`robosc.expr.evaluation.evaluate` exactly: integers never
overflow and are never rounded to a double (Python integers are used where 64 bits might not
suffice), and division is that of IEEE 754.
"""

from __future__ import annotations

from collections.abc import Mapping
from functools import lru_cache
from typing import Any, TypeAlias

import numpy as np
from numpy.typing import NDArray

from robosc.expr.evaluation import constant, scalar_of
from robosc.expr.traversal import fold
from robosc.expr.tree import (
    Aggregate,
    Call,
    Convert,
    Expr,
    Holds,
    Leaf,
    Literal,
    Operation,
    Part,
    PhaseRef,
    StateRef,
    TestRef,
    VariableRef,
)
from robosc.expr.types import EnumType, StringType, Type
from robosc.language.operators import EXACT_IN_DOUBLE, EXACT_IN_INT64, Operator, Range
from robosc.plant.automaton import Plant, StateVariable
from robosc.plant.data.classes import Classes

Bools: TypeAlias = NDArray[np.bool_]


Indexes: TypeAlias = NDArray[np.intp]


IndexArrays: TypeAlias = Mapping[int, Indexes]
"""Index arrays by state variable, broadcastable against each other."""


def evaluate_vectorised(plant: Plant, expr: Expr, columns: IndexArrays) -> NDArray[Any]:
    """Return the values of an expression for all combinations of the columns.

    The result broadcasts against the columns; it need not have their full shape. Values of enums
    are their index in the type. The expression reads no parameter: those are substituted before.
    """

    def leaf(node: Literal | Leaf) -> NDArray[Any]:
        if isinstance(node, Literal):
            return _literal(node.value, node.type)
        variable = plant.variable_of(node)
        assert variable is not None, "a parameter without value"
        return _leaf(plant.variables[variable], node, columns[variable])

    return fold(expr, leaf, _apply, known=_constant_of_data)


def _constant_of_data(node: Expr) -> NDArray[Any] | None:
    """What a function of constant arrays or objects comes to; they have no numpy arrays."""
    if not isinstance(node, Call | Aggregate | Part | Holds):
        return None
    value = constant(node)
    return None if value is None else _literal(value, node.type)


def _leaf(variable: StateVariable, expr: Expr, indexes: Indexes) -> NDArray[Any]:
    match expr:
        case StateRef(places=(name,)) | PhaseRef(places=(name,)):
            result: NDArray[Any] = indexes == variable.values.index(name)
            return result
        case StateRef(places=names) | PhaseRef(places=names):
            return np.isin(indexes, [variable.values.index(name) for name in names])
        case VariableRef(type=EnumType(values=names)) | TestRef(type=EnumType(values=names)):
            codes = [names.index(str(v)) for v in variable.values]
            return np.array(codes, dtype=np.int64)[indexes]
    values = variable.values
    if isinstance(values, range):
        fits = max(abs(values[0]), abs(values[-1])) < EXACT_IN_INT64
        return np.asarray(indexes.astype(np.int64 if fits else object) + values[0])
    if isinstance(values, Classes):
        return _numbers(values)[indexes]
    return np.array(values, dtype=np.bool_)[indexes]


@lru_cache(maxsize=8)
def _numbers(classes: Classes) -> NDArray[Any]:
    """Return the representatives of classes, strings and large integers as Python objects.

    Cached, since each of thousands of conditions may compare the same variable.
    """
    fits = not isinstance(classes.type, StringType) and all(
        isinstance(value, float) or abs(value) < EXACT_IN_INT64 for value in classes
    )
    return np.array(list(classes), dtype=None if fits else object)


def _literal(value: object, type_: Type) -> NDArray[Any]:
    if isinstance(type_, EnumType):
        return np.array(type_.values.index(str(value)), dtype=np.int64)
    if isinstance(value, int) and not isinstance(value, bool) and abs(value) >= EXACT_IN_INT64:
        return np.array(value, dtype=object)
    return np.array(value, dtype=object if isinstance(type_, StringType) else None)


def _apply(node: Operation, operands: tuple[NDArray[Any], ...]) -> NDArray[Any]:
    operation = node.operation
    if isinstance(node, Convert):
        values, scalar = node.type.values, scalar_of(node)
        codes = np.frompyfunc(lambda value: values.index(str(scalar(value))), 1, 1)
        with np.errstate(all="ignore"):  # rules may compare NaN
            return np.asarray(codes(operands[0].astype(object)), dtype=np.int64)
    if not _exact(operation, operands):
        function = np.frompyfunc(operation.scalar, len(operands), 1)
        with np.errstate(all="ignore"):
            outcome = function(*(side.astype(object) for side in operands))
        return np.asarray(outcome, dtype=np.bool_ if operation.is_comparison else object)
    with np.errstate(all="ignore"):
        return np.asarray(getattr(np, operation.array)(*operands))


def _exact(operation: Operator, operands: tuple[NDArray[Any], ...]) -> bool:
    """Whether numpy's own arithmetic cannot differ from Python's."""
    kinds = {side.dtype.kind for side in operands}
    if "O" in kinds or not operation.array:
        return False
    if kinds == {"i"}:
        ranges = [_range(side) for side in operands]
        return operation.int64(ranges[0], ranges[-1])
    integers = [side for side in operands if side.dtype.kind == "i"]
    return all(_range(side).magnitude <= EXACT_IN_DOUBLE for side in integers)


def _range(values: NDArray[Any]) -> Range:
    return Range(int(values.min()), int(values.max())) if values.size else Range(0, 0)
