"""The value of an expression: the reference that everything else is compared with.

``and``, ``or`` and ``=>`` look at their right side only when the left does not decide. That matters
for undefined parts alone (an array index past the end): a part that is not looked at does no harm,
any other makes the whole expression undefined.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Mapping
from contextlib import suppress
from functools import partial
from typing import Any, cast

from robosc.model.expr import (
    Aggregate,
    Binary,
    Convert,
    ElementRef,
    Expr,
    Leaf,
    Literal,
    Operation,
    ParameterRef,
    Part,
    ValueRef,
    condition_of,
)
from robosc.model.traversal import fold, parameters_of, walk
from robosc.model.types import EnumType, Value
from robosc.runtime.functions import element, is_so
from robosc.runtime.values import Undefined

__all__ = ["Undefined", "constant", "converted", "evaluate", "part_of_value", "scalar_of"]


def evaluate(expr: Expr, lookup: Callable[[Leaf], Value | None]) -> Value:
    """The value of an expression, each leaf looked up; parameters have their defaults.

    Raises:
        Undefined: a leaf that is needed was looked up as None.
    """

    bound: dict[str, Value] = {}

    def leaf(node: Literal | Leaf) -> Value:
        if isinstance(node, Literal):
            return node.value
        if isinstance(node, ParameterRef):
            return node.parameter.default
        if isinstance(node, ElementRef):
            return part_of_value(bound[node.variable], node.path)
        found = lookup(node)
        if found is None:
            raise Undefined
        return found

    def aggregate(node: Aggregate, array: Value, visit: Callable[[Expr], Value]) -> Value:
        results: list[Value] = []
        for item in cast(Iterable[Value], array):
            bound[node.variable] = item
            try:
                if node.condition is None or visit(node.condition):
                    results.append(visit(node.element))
            except Undefined:
                continue  # it does not count
        result: Value = node.operation.scalar(results)
        return result

    def total(operand: Callable[[], Value]) -> Value:
        return is_so(operand)

    return fold(expr, leaf, _apply, _lazily, bound=aggregate, total=total)


def part_of_value(value: Any, path: tuple[str | int, ...]) -> Value:
    """A part of an object that came in, of a message or as a mapping."""
    for part in path:
        if isinstance(part, str):
            value = value[part] if isinstance(value, Mapping) else getattr(value, part)
        else:
            value = element(value, part)
    found: Value = value
    return found


def _apply(node: Operation, operands: tuple[Value, ...]) -> Value:
    return scalar_of(node)(*operands)


def _lazily(node: Binary, left: Value, right: Callable[[], Value]) -> Value:
    operation = node.operation
    return operation.decided if left is operation.decider else right()


def scalar_of(node: Operation) -> Callable[..., Value]:
    """What an operation makes of the values of its operands."""
    match node:
        case Convert(type=type_):
            return partial(converted, type_)
        case Part():
            return partial(_typed_part, node)
    return node.operation.scalar


def _typed_part(node: Part, whole: Value) -> Value:
    part = part_of_value(whole, node.path)
    return converted(node.type, part) if isinstance(node.type, EnumType) else part


def converted(enum: EnumType, value: Any) -> Value:
    """What the rules of an enum make of a value of its source type."""

    def look(leaf: Leaf) -> Value | None:
        assert isinstance(leaf, ValueRef)
        part = part_of_value(value, leaf.path)
        return converted(leaf.type, part) if isinstance(leaf.type, EnumType) else part

    for rule in enum.rules:
        with suppress(Undefined):
            if evaluate(condition_of(rule), look):
                return rule.value
    return enum.default


def constant(expr: Expr) -> Value | None:
    """The value of an expression that reads nothing; None if it reads or is no finite number."""
    if not all(isinstance(part, Literal | Operation) for part in walk(expr)):
        return None
    if any(True for _ in parameters_of(expr)):
        return None  # in the rules of an enum
    value = evaluate(expr, lambda leaf: None)
    return None if isinstance(value, float) and not math.isfinite(value) else value
