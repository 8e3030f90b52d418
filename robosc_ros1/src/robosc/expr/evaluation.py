"""Evaluation of expressions: the reference with which all other implementations are compared.

``and``, ``or`` and ``=>`` evaluate their right operand only if the left one does not decide. This
matters only for undefined parts, such as an array index past the end: the whole expression is
undefined if a part that is evaluated is.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Mapping
from contextlib import suppress
from functools import partial
from typing import Any, cast

from robosc.expr.traversal import fold, parameters_of, walk
from robosc.expr.tree import (
    Aggregate,
    Binary,
    Convert,
    ElementRef,
    Expr,
    Leaf,
    Literal,
    Made,
    Operation,
    ParameterRef,
    Part,
    ValueRef,
    condition_of,
)
from robosc.expr.types import EnumType, Type, Value
from robosc.runtime.core.functions import element, is_so, otherwise
from robosc.runtime.core.values import Undefined


def evaluate(expr: Expr, lookup: Callable[[Leaf], Value | None]) -> Value:
    """The value of an expression; ``lookup`` gives those of leaves, parameters have their defaults.

    Raises:
        Undefined: ``lookup`` returned None for a leaf that is needed, or an index is past the end.
    """

    bound: dict[str, Value] = {}

    def leaf(node: Literal | Leaf) -> Value:
        if isinstance(node, Literal):
            return node.value
        if isinstance(node, ParameterRef):
            return node.parameter.default
        if isinstance(node, ElementRef):
            return as_read(part_of_value(bound[node.variable], node.path), node.carried)
        found = lookup(node)
        if found is None:
            raise Undefined
        return found

    def aggregate(node: Aggregate, array: Value, visit: Callable[[Expr], Value]) -> Value:
        condition, results = node.condition, cast(list[Value], [])
        for position, item in enumerate(cast(Iterable[Value], array)):
            bound.update({node.variable: item, node.position: position})
            if condition is not None and not is_so(lambda: visit(condition)):
                continue
            # An element for which it is undefined does not count, but in a new array.
            with suppress(*(() if node.makes_array else (Undefined,))):
                results.append(visit(node.element))
        result: Value = node.operation.scalar(results)
        return result

    found: Value = fold(
        expr, leaf, _apply, _lazily, bound=aggregate, total=is_so, otherwise=otherwise
    )
    return found


def part_of_value(value: Any, path: tuple[str | int, ...]) -> Value:
    """The part of a received value, a message or a mapping, at a path.

    Raises:
        Undefined: an index is past the end of its array.
    """
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
    """The function that computes an operation's value from those of its operands."""
    match node:
        case Convert(type=type_):
            return partial(converted, type_)
        case Made():
            return lambda *values: node.of(values)
        case Part():
            return lambda whole: as_read(part_of_value(whole, node.path), node.carried)
    return node.operation.scalar


def as_read(part: Value, type_: Type) -> Value:
    """A part of a whole, in which enums have not been converted yet."""
    return converted(type_, part) if isinstance(type_, EnumType) else part


def converted(enum: EnumType, value: Any) -> Value:
    """The value of an enum for a value of its source type: that of the first rule that holds."""

    def look(leaf: Leaf) -> Value | None:
        assert isinstance(leaf, ValueRef)
        return as_read(part_of_value(value, leaf.path), leaf.type)

    for rule in enum.rules:
        with suppress(Undefined):
            if evaluate(condition_of(rule), look):
                return rule.value
    return enum.default


def constant(expr: Expr) -> Value | None:
    """The value of a constant expression; None for others, and for infinite numbers and NaN."""
    parts = list(walk(expr))
    bound = {
        name
        for part in parts
        if isinstance(part, Aggregate)
        for name in (part.variable, part.position)
    }
    if not all(
        isinstance(part, Literal | Operation)
        or (isinstance(part, ElementRef) and part.variable in bound)
        for part in parts
    ):
        return None
    if any(True for _ in parameters_of(expr)):
        return None  # in the rules of an enum
    value = evaluate(expr, lambda leaf: None)
    return None if isinstance(value, float) and not math.isfinite(value) else value
