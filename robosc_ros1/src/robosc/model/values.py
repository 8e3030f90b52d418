"""Types in words, compatibility of types, and constants."""

from __future__ import annotations

import math

from robosc.model.expr import Binary, Expr, Literal, Unary
from robosc.model.report import Report
from robosc.model.types import (
    ArrayType,
    BooleanType,
    DoubleType,
    EnumType,
    IntegerType,
    NoneType,
    ObjectType,
    StringType,
    Type,
    Value,
    is_number,
)

__all__ = [
    "accepts", "check_range", "coerce", "comparable", "default_value", "describe", "fold",
    "is_basic",
]  # fmt: skip


def describe(type_: Type) -> str:
    """A value of the type in words: ``a boolean``, ``a value of Distance``."""
    match type_:
        case NoneType():
            return "none"
        case IntegerType():
            return f"an {type_}"
        case ArrayType():
            return f"an {type_}"
        case EnumType(name=name):
            return f"a value of {name}"
        case ObjectType(name=name):
            return f"an object {name}"
    return f"a {type_}"


def is_basic(type_: Type) -> bool:
    return isinstance(type_, BooleanType | IntegerType | DoubleType | StringType)


def accepts(target: Type, given: Type) -> bool:
    """Whether a value of type ``given`` may stand where ``target`` is declared.

    Ranges do not matter here: leaving one is the plant's affair, and that of ``check_range``.
    """
    match target, given:
        case (IntegerType(), IntegerType()):
            return True
        case (DoubleType(), _):
            return is_number(given)
    return target == given


def comparable(left: Type, right: Type) -> bool:
    """Whether ``=`` may compare the two: two values of one type, numbers counting as one."""
    if is_number(left) and is_number(right):
        return True
    return left == right and not isinstance(left, ArrayType | ObjectType | NoneType)


def fold(expr: Expr) -> Value | None:
    """The value of a constant expression; None if it reads anything or is no finite number."""
    match expr:
        case Literal(value=value):
            return value
        case Unary(operator=operator, operand=operand):
            inner = fold(operand)
            if inner is None:
                return None
            if operator == "!":
                return not inner
            return None if isinstance(inner, str) else -inner
        case Binary(operator=operator, left=left, right=right):
            first, second = fold(left), fold(right)
            if first is None or second is None:
                return None
            return _apply(operator, first, second)
    return None


def _apply(operator: str, left: Value, right: Value) -> Value | None:
    match operator:
        case "=":
            return left == right
        case "!=":
            return left != right
        case "and":
            return bool(left and right)
        case "or":
            return bool(left or right)
        case "=>":
            return bool(not left or right)
    if isinstance(left, str) or isinstance(right, str):
        return None
    match operator:
        case "<":
            return left < right
        case "<=":
            return left <= right
        case ">":
            return left > right
        case ">=":
            return left >= right
    try:
        return _finite(_arithmetic(operator, left, right))
    except (OverflowError, ZeroDivisionError):
        return None


def _arithmetic(operator: str, left: int | float, right: int | float) -> int | float:
    match operator:
        case "+":
            return left + right
        case "-":
            return left - right
        case "*":
            return left * right
    return left / right


def _finite(number: int | float) -> int | float | None:
    return number if isinstance(number, int) or math.isfinite(number) else None


def coerce(expr: Expr, target: Type) -> Expr:
    """The expression, integer literals for a double made doubles."""
    if isinstance(target, DoubleType) and isinstance(expr, Literal) and type(expr.value) is int:
        return Literal(float(expr.value), target, expr.span)
    return expr


def check_range(expr: Expr, target: Type, what: str, report: Report) -> None:
    """Report a constant outside the bounds of a ranged integer."""
    if not isinstance(target, IntegerType) or target.bounds is None or expr.span is None:
        return
    value = fold(expr)
    low, high = target.bounds
    if type(value) is int and not low <= value <= high:
        report.add(
            "out-of-range",
            expr.span,
            f"{value} is outside the range of {what}",
            f"{target} takes {low} to {high}",
        )


def default_value(type_: Type) -> Value:
    """What a variable without initial value starts as (LANGUAGE section 4)."""
    match type_:
        case BooleanType():
            return False
        case IntegerType(bounds=None):
            return 0
        case IntegerType(bounds=(low, high)):
            return min(max(0, low), high)
        case DoubleType():
            return 0.0
        case StringType():
            return ""
        case EnumType(default=default):
            return default
    raise ValueError(f"no variable can be {describe(type_)}")
