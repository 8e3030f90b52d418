"""The kinds of numbers that comparisons with numbers that stand tell apart."""

from __future__ import annotations

import math
from collections.abc import Iterable
from contextlib import suppress
from itertools import pairwise
from typing import Any

from robosc.expr.traversal import may_be_undefined, walk
from robosc.expr.tree import Binary, ElementRef, Expr, ValueRef, VariableRef
from robosc.expr.types import BooleanType, DoubleType, IntegerType, domain
from robosc.runtime.core.values import Undefined
from robosc.traces.exact_steps import NOTHING, function, keys_read
from robosc.traces.samples import NEAR


def regions(exprs: Iterable[Expr]) -> dict[Any, list[Any]]:
    """The variables, by key, and parts of what an event carries, by path, with which expressions do
    no more than to copy them, or to compare them with numbers that stand; of each a value of every
    kind: where a comparison comes out otherwise, or its numbers are near each other."""
    leaves: dict[Any, list[ValueRef | VariableRef]] = {}
    compared: dict[Any, list[float]] = {}
    whole = [expr for expr in exprs if not isinstance(expr, ValueRef | VariableRef)]
    for part in (part for expr in whole for part in walk(expr)):
        if isinstance(part, ValueRef | VariableRef):
            leaves.setdefault(_key(part), []).append(part)
        elif isinstance(part, Binary) and part.operation.is_comparison:
            for one, other in ((part.left, part.right), (part.right, part.left)):
                number = _number(other)
                if isinstance(one, ValueRef | VariableRef) and number is not None:
                    compared.setdefault(_key(one), []).append(number)
    found = {key: _values(some[0], compared.get(key, [])) for key, some in leaves.items()}
    return {
        key: [*values, None] if any(map(may_be_undefined, leaves[key])) else values
        for key, values in found.items()
        if values and len(leaves[key]) == len(compared.get(key, leaves[key]))
    }


def _key(leaf: ValueRef | VariableRef) -> Any:
    return leaf.key if isinstance(leaf, VariableRef) else leaf.path


def _values(leaf: ValueRef | VariableRef, numbers: list[float]) -> list[Any]:
    """A value of every kind; none, if the plant knows the values, or nothing is known of them."""
    match leaf.type:
        case BooleanType() if isinstance(leaf, ValueRef):
            return [True, False]
        case IntegerType() if numbers and (isinstance(leaf, ValueRef) or domain(leaf.type) is None):
            return _integers(numbers)
        case DoubleType() if numbers:
            return _doubles(numbers)
    return []


def _number(expr: Expr) -> float | None:
    """What an expression comes to wherever it is evaluated."""
    if keys_read([expr]) or any(isinstance(part, ValueRef | ElementRef) for part in walk(expr)):
        return None
    with suppress(Undefined):
        value = function(expr)({}, NOTHING)
        return value if type(value) in (int, float) and math.isfinite(value) else None
    return None


def _integers(numbers: Iterable[float]) -> list[Any]:
    return sorted({math.floor(n) + step for n in numbers for step in range(-2, 4)})


def _doubles(numbers: Iterable[float]) -> list[Any]:
    ends = sorted(
        {n + sign * NEAR * 1.5 * max(1.0, abs(n)) for n in numbers for sign in (-1, 0, 1)}
    )
    between = [(one + other) / 2 for one, other in pairwise(ends)]
    return [*numbers, *between, ends[0] - 1.0, ends[-1] + 1.0, math.nan]
