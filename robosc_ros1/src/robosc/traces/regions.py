"""The kinds of numbers that comparisons with numbers that stand tell apart."""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Iterable, Mapping
from contextlib import suppress
from itertools import pairwise
from typing import Any

from robosc.expr.traversal import walk
from robosc.expr.tree import Binary, ElementRef, Expr, ValueRef, VariableRef
from robosc.expr.types import DoubleType, IntegerType, Type, domain
from robosc.runtime.core.values import Undefined
from robosc.traces.exact_steps import NOTHING, function, keys_read
from robosc.traces.samples import NEAR


def regions(exprs: Iterable[Expr], types: Mapping[str, Type]) -> dict[str, list[Any]]:
    """The variables, by key, with which expressions do no more than to compare them with numbers
    that stand; of each a value of every kind: where a comparison comes out otherwise, or its
    numbers are near each other."""
    read, compared = Counter[str](), dict[str, list[float]]()
    for part in (part for expr in exprs for part in walk(expr)):
        if isinstance(part, VariableRef):
            read[part.key] += 1
        elif isinstance(part, Binary) and part.operation.is_comparison:
            for one, other in ((part.left, part.right), (part.right, part.left)):
                number = _number(other) if isinstance(one, VariableRef) else None
                if isinstance(one, VariableRef) and number is not None:
                    compared.setdefault(one.key, []).append(number)
    return {
        key: _integers(numbers) if isinstance(types[key], IntegerType) else _doubles(numbers)
        for key, numbers in compared.items()
        if read[key] == len(numbers)
        and isinstance(types[key], DoubleType | IntegerType)
        and domain(types[key]) is None
    }


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
