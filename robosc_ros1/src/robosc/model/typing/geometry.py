"""``yaw``, ``distance`` and ``sector``, as functions of what their objects are made of."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any

from robosc.expr import evaluation, traversal, tree
from robosc.expr.types import ArrayType, DoubleType, ObjectType, is_number
from robosc.language.functions import GEOMETRY
from robosc.language.operators import BINARY, Operand
from robosc.model.diagnostics import Report
from robosc.model.typing.compatibility import describe, result_type
from robosc.model.typing.expected import ExpectedType, needs_of
from robosc.source import Span
from robosc.syntax.nodes import CallNode, ExprNode

_DOUBLE = DoubleType()


def typed_geometry(
    node: CallNode, check: Callable[[ExprNode, ExpectedType, str], tree.Expr | None], report: Report
) -> tree.Expr | None:
    """The expression for which a call of a function in ``GEOMETRY`` stands; None after an error."""
    name = node.function.root.text
    objects, numbers, fields, words = GEOMETRY[name]
    if len(node.arguments) != objects + numbers:
        count = f"{objects + numbers} argument{'s' * (objects + numbers > 1)}"
        message = f"'{name}' takes {count}, not {len(node.arguments)}"
        report.add("type-mismatch", node.span, message)
        return None
    parts = []
    for argument in node.arguments[:objects]:
        found = check(argument, needs_of(Operand.ANY), f"'{name}'")
        if found is None:
            return None
        if not _has(found, fields):
            message = f"'{name}' needs {words}, not {describe(found.type)}"
            hint = f"an object with the numbers {', '.join(fields)}"
            if fields[0] == "ranges":
                hint = (
                    f"an object with an array of numbers 'ranges', and {' and '.join(fields[1:])}"
                )
            report.add("type-mismatch", argument.span, message, hint)
            return None
        if (missing := _missing(found, fields)) is not None:
            message = f"the constant has no value for '{missing}'"
            report.add("unknown-member", argument.span, message)
            return None
        parts.append([_part(found, field, node.span) for field in fields])
    angles = [check(a, needs_of(Operand.NUMBER), f"'{name}'") for a in node.arguments[objects:]]
    given = [angle for angle in angles if angle is not None]
    if len(given) < len(angles):
        return None
    match name:
        case "sector":
            operands = (*parts[0], *given)
            return tree.Call("sector", operands, parts[0][0].type, node.span)
        case "yaw":
            return _yaw(*parts[0])
    return _distance(*parts)


def _has(expr: tree.Expr, fields: Sequence[str]) -> bool:
    type_ = expr.type
    if not isinstance(type_, ObjectType):
        return False
    types = {field: type_.property(field) for field in fields}
    ranges = types.pop("ranges", ArrayType(_DOUBLE))
    numbers = [*types.values(), ranges.element if isinstance(ranges, ArrayType) else None]
    return all(part is not None and is_number(part) for part in numbers)


def _missing(expr: tree.Expr, fields: Sequence[str]) -> str | None:
    """A field that a constant leaves out; None if it has all."""
    if not isinstance(expr, tree.Literal):
        return None
    value: Any = expr.value
    return next((field for field in fields if field not in value), None)


def _part(whole: tree.Expr, field: str, span: Span) -> tree.Expr:
    assert isinstance(whole.type, ObjectType)
    type_ = whole.type.property(field)
    assert type_ is not None
    if isinstance(whole, tree.Literal):
        return tree.Literal(evaluation.part_of_value(whole.value, (field,)), type_, span)
    return traversal.part_of(whole, (field,), type_, span)


def _of(operator: str, left: tree.Expr, right: tree.Expr) -> tree.Expr:
    type_ = result_type(BINARY[operator].result, [left.type, right.type])
    return tree.Binary(operator, left, right, type_, left.span)


def _yaw(x: tree.Expr, y: tree.Expr, z: tree.Expr, w: tree.Expr) -> tree.Expr:
    """The rotation about the upward axis, in radians (REP 103)."""
    two, one = tree.Literal(2.0, _DOUBLE, x.span), tree.Literal(1.0, _DOUBLE, x.span)
    sine = _of("*", two, _of("+", _of("*", w, z), _of("*", x, y)))
    cosine = _of("-", one, _of("*", two, _of("+", _of("*", y, y), _of("*", z, z))))
    return tree.Call("atan2", (sine, cosine), _DOUBLE, x.span)


def _distance(first: list[tree.Expr], second: list[tree.Expr]) -> tree.Expr:
    x, y, z = (_of("-", a, b) for a, b in zip(first, second, strict=True))
    flat = tree.Call("hypot", (x, y), _DOUBLE, x.span)
    return tree.Call("hypot", (flat, z), _DOUBLE, x.span)
