"""What can be done with a resolved expression: build, evaluate, print as DSL text or as Python.

``and``, ``or`` and ``=>`` look at their right side only when the left does not decide. That matters
for undefined parts alone (an array index past the end, LANGUAGE section 5): a part that is not
looked at does no harm, any other makes the whole expression undefined.
"""

from __future__ import annotations

import operator
from collections.abc import Callable, Iterable, Sequence
from typing import Any, TypeAlias

from robosc.model.entities import Robot
from robosc.model.expr import (
    FALSE,
    TRUE,
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
from robosc.model.types import BooleanType, DoubleType, IntegerType, StringType, Value
from robosc.runtime.values import divide, widen

__all__ = [
    "OPERATIONS", "Leaf", "Undefined", "conjunction", "disjunction", "divide", "evaluate",
    "may_be_huge", "negation", "to_dsl", "to_python", "widen",
]  # fmt: skip

Leaf: TypeAlias = VariableRef | StateRef | PhaseRef | ValueRef
_BOOLEAN = BooleanType()


class Undefined(Exception):
    """An expression has no value: it reads an array element that did not come."""


def negation(expr: Expr) -> Expr:
    """``!expr``, without piling up negations."""
    match expr:
        case Literal(value=bool(value)):
            return FALSE if value else TRUE
        case Unary(operator="!", operand=operand):
            return operand
        case Binary(operator="=", left=left, right=right):
            return Binary("!=", left, right, _BOOLEAN)
        case Binary(operator="!=", left=left, right=right):
            return Binary("=", left, right, _BOOLEAN)
    return Unary("!", expr, _BOOLEAN)


def conjunction(parts: Iterable[Expr]) -> Expr:
    """All of them; TRUE if there are none. Repeated and constant parts are dropped."""
    return _chain("and", parts, TRUE, FALSE)


def disjunction(parts: Iterable[Expr]) -> Expr:
    """At least one of them; FALSE if there are none."""
    return _chain("or", parts, FALSE, TRUE)


def _chain(operator_: str, parts: Iterable[Expr], unit: Literal, zero: Literal) -> Expr:
    kept = [p for p in dict.fromkeys(parts) if p != unit]
    if zero in kept:
        return zero
    return _joined(operator_, kept) if kept else unit


_LONG_CHAIN = 64
"""A longer chain becomes a low tree, as those that are written do: many functions recurse."""


def _joined(operator_: str, parts: Sequence[Expr]) -> Expr:
    if len(parts) > _LONG_CHAIN:
        half = len(parts) // 2
        sides = _joined(operator_, parts[:half]), _joined(operator_, parts[half:])
        return Binary(operator_, *sides, _BOOLEAN)
    result = parts[0]
    for part in parts[1:]:
        result = Binary(operator_, result, part, _BOOLEAN)
    return result


def _widening(operation: Callable[[Any, Any], Any]) -> Callable[[Any, Any], Any]:
    def widened(left: Any, right: Any) -> Any:
        try:
            return operation(left, right)
        except OverflowError:  # a double, and an integer beyond the doubles
            return operation(widen(left), widen(right))

    return widened


OPERATIONS: dict[str, Callable[[Any, Any], Any]] = {
    "=": operator.eq,
    "!=": operator.ne,
    "<": operator.lt,
    "<=": operator.le,
    ">": operator.gt,
    ">=": operator.ge,
    "+": _widening(operator.add),
    "-": _widening(operator.sub),
    "*": _widening(operator.mul),
    "/": divide,
}
"""What the operators mean for any two values; ``and``, ``or`` and ``=>`` are evaluated in part."""


def evaluate(expr: Expr, lookup: Callable[[Leaf], Value | None]) -> Value:
    """The value of an expression, each leaf looked up.

    Raises:
        Undefined: a leaf that is needed was looked up as None.
    """
    match expr:
        case Literal(value=value):
            return value
        case Unary(operator=op, operand=operand):
            inner = evaluate(operand, lookup)
            return (not inner) if op == "!" else -inner  # type: ignore[operator]
        case Binary(operator="and", left=left, right=right):
            return evaluate(left, lookup) and evaluate(right, lookup)
        case Binary(operator="or", left=left, right=right):
            return evaluate(left, lookup) or evaluate(right, lookup)
        case Binary(operator="=>", left=left, right=right):
            return (not evaluate(left, lookup)) or evaluate(right, lookup)
        case Binary(operator=op, left=left, right=right):
            result: Value = OPERATIONS[op](evaluate(left, lookup), evaluate(right, lookup))
            return result
        case _:
            found = lookup(expr)
            if found is None:
                raise Undefined
            return found


# --- DSL text ------------------------------------------------------------------------------------

_DSL_LEVEL = {"=>": 1, "or": 2, "and": 3, "=": 4, "!=": 4, "<": 5, "<=": 5, ">": 5, ">=": 5}
_DSL_LEVEL |= {"+": 6, "-": 6, "*": 7, "/": 7}
_UNARY_LEVEL = 8
_RESERVED = frozenset({"value", "true", "false", "and", "or"})


def to_dsl(expr: Expr, robot: Robot) -> str:
    """The expression in the language's own syntax, as it would stand in a requirement.

    A phase, which the language has no word for, reads ``grab.busy``.
    """
    component_names = {component.name for component in robot.components}

    def leaf(node: Leaf) -> str:
        match node:
            case (
                VariableRef(component=component, variable=name)
                | StateRef(component=component, state=name)
            ):
                return f"{_escape(component)}.{_escape(name)}"
            case PhaseRef(communication=key):
                name = robot.display_names[key]
                name = key if name in component_names else name
                return ".".join(_escape(part) for part in name.split(".")) + ".busy"
            case ValueRef(path=path):
                return "value" + "".join(
                    f"[{part}]" if isinstance(part, int) else f".{_escape(part)}" for part in path
                )

    def text(node: Expr) -> tuple[str, int]:
        match node:
            case Literal():
                negative = not isinstance(node.value, bool | str) and str(node.value)[0] == "-"
                return _literal(node), _UNARY_LEVEL if negative else 9
            case Unary(operator=op, operand=operand):
                return op + wrap(operand, _UNARY_LEVEL), _UNARY_LEVEL
            case Binary(operator=op, left=left, right=right):
                level = _DSL_LEVEL[op]
                # Only => groups to the right, all others to the left.
                left_level, right_level = (level + 1, level) if op == "=>" else (level, level + 1)
                return f"{wrap(left, left_level)} {op} {wrap(right, right_level)}", level
            case _:
                return leaf(node), 9

    def wrap(node: Expr, least: int) -> str:
        inner, level = text(node)
        return inner if level >= least else f"({inner})"

    return text(expr)[0]


def _escape(name: str) -> str:
    return f"^{name}" if name in _RESERVED else name


def _literal(node: Literal) -> str:
    value = node.value
    if isinstance(value, bool):
        return "true" if value else "false"
    if isinstance(value, str):
        if isinstance(node.type, StringType):
            escaped = value.replace("\\", "\\\\").replace('"', '\\"')
            return '"' + escaped.replace("\n", "\\n").replace("\t", "\\t") + '"'
        return _escape(value)
    text = repr(value)
    # The language wants a point in a double: 1e+16 is not one of its spellings.
    return text.replace("e+", "E").replace("e-", "E-") if isinstance(value, float) else text


# --- Python text ---------------------------------------------------------------------------------

_PYTHON = {
    "or": ("or", 1),
    "and": ("and", 2),
    "=": ("==", 4),
    "!=": ("!=", 4),
    "<": ("<", 4),
    "<=": ("<=", 4),
    ">": (">", 4),
    ">=": (">=", 4),
    "+": ("+", 5),
    "-": ("-", 5),
    "*": ("*", 6),
}


def may_be_huge(expr: Expr) -> bool:
    """Whether this is an integer that may lie beyond the doubles.

    What comes in has 64 bits at the most, so that takes a variable without a range, or a product of
    more than a dozen factors.
    """
    if not isinstance(expr.type, IntegerType):
        return False
    parts = list(walk(expr))
    factors = sum(isinstance(part, Binary) and part.operator == "*" for part in parts)
    return factors > 12 or any(
        isinstance(part, VariableRef) and part.type == IntegerType() for part in parts
    )


def to_python(
    expr: Expr,
    leaf: Callable[[Leaf], str],
    literal: Callable[[Literal], str] = lambda node: repr(node.value),
) -> str:
    """The expression as Python source; ``leaf`` and ``literal`` spell the parts.

    Division reads ``divide(a, b)``, and an integer that may be too large for the double beside it
    ``widen(a)``: the caller's namespace must hold functions like :func:`divide` and :func:`widen`.
    Spellings that are not one operand (``a == b``) must bring their own parentheses.
    """

    def text(node: Expr) -> tuple[str, int]:
        match node:
            case Literal():
                spelled = literal(node)
                return spelled, 7 if spelled.startswith("-") else 8
            case Unary(operator="!", operand=operand):
                return f"not {wrap(operand, 3)}", 3
            case Unary(operand=operand):
                return f"-{wrap(operand, 8)}", 7
            case Binary(operator="/", left=left, right=right):
                return f"divide({text(left)[0]}, {text(right)[0]})", 8
            case Binary(operator="=>", left=left, right=right):
                return f"not {wrap(left, 3)} or {wrap(right, 1)}", 1
            case Binary(operator=op, left=left, right=right):
                symbol, level = _PYTHON[op]
                # Comparisons chain in Python and do not here, so both sides must bind tighter.
                left_level = level + 1 if level == 4 else level
                if isinstance(node.type, DoubleType):
                    sides = widened(left, left_level), widened(right, level + 1)
                    return f"{sides[0]} {symbol} {sides[1]}", level
                return f"{wrap(left, left_level)} {symbol} {wrap(right, level + 1)}", level
            case _:
                return leaf(node), 8

    def wrap(node: Expr, least: int) -> str:
        inner, level = text(node)
        return inner if level >= least else f"({inner})"

    def widened(node: Expr, least: int) -> str:
        return f"widen({text(node)[0]})" if may_be_huge(node) else wrap(node, least)

    return text(expr)[0]
