"""Rules about types: texts for messages, compatibility, results, and ranges of constants."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from robosc.expr.evaluation import constant
from robosc.expr.tree import Expr, Literal
from robosc.expr.types import (
    ArrayType,
    BooleanType,
    DoubleType,
    DurationType,
    EnumType,
    IntegerType,
    NoneType,
    ObjectType,
    StringType,
    Type,
    Value,
    is_number,
)
from robosc.language.operators import Result
from robosc.model.diagnostics import Report


def describe(type_: Type) -> str:
    """The text for a value of a type in messages: ``a boolean``, ``a value of Distance``."""
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


def result_type(result: Result, operands: Sequence[Type]) -> Type:
    """The type of an operation's result."""
    match result:
        case Result.BOOLEAN:
            return BooleanType()
        case Result.NUMBER if all(isinstance(type_, IntegerType) for type_ in operands):
            return IntegerType()
        case Result.INTEGER:
            return IntegerType()
        case Result.STRING:
            return StringType()
        case Result.SAME if len(set(operands)) == 1:
            return operands[0]
        case Result.SAME:  # of two ranges
            return IntegerType()
        case Result.SUM:
            left = next(iter(operands))
            return left if left == StringType() else result_type(Result.NUMBER, operands)
    return DoubleType()


def type_of(value: Value) -> Type:
    """The type of a plain value; a str is taken as a string, not as the value of an enum."""
    match value:
        case bool():
            return BooleanType()
        case int():
            return IntegerType()
        case float():
            return DoubleType()
    return StringType()


def is_basic(type_: Type) -> bool:
    """Whether a type is boolean, integer, double or string."""
    return isinstance(type_, BooleanType | IntegerType | DoubleType | StringType)


def accepts(target: Type, given: Type) -> bool:
    """Whether a value of type ``given`` may be used where ``target`` is declared.

    Ranges are ignored: constants are checked by :func:`check_range`, all else by synthesis.
    """
    match target, given:
        case (IntegerType(), IntegerType()):
            return True
        case (DoubleType(), _):
            return is_number(given)
    return target == given


def comparable(left: Type, right: Type) -> bool:
    """Whether ``=`` may compare two types: equal ones, and any two types of numbers."""
    if is_number(left) and is_number(right):
        return True
    return left == right and not isinstance(left, ArrayType | ObjectType | NoneType | DurationType)


def coerce(expr: Expr, target: Type) -> Expr:
    """The expression; an integer literal becomes a double if the target is one."""
    if isinstance(target, DoubleType) and isinstance(expr, Literal) and type(expr.value) is int:
        return Literal(float(expr.value), target, expr.span)
    return expr


def check_range(expr: Expr, target: Type, what: str, report: Report) -> None:
    """Report a constant outside the bounds of a ranged integer."""
    if not isinstance(target, IntegerType) or target.bounds is None or expr.span is None:
        return
    value = constant(expr)
    low, high = target.bounds
    if type(value) is int and not low <= value <= high:
        report.add(
            "out-of-range",
            expr.span,
            f"{value} is outside the range of {what}",
            f"{target} takes {low} to {high}",
        )


def default_value(type_: Type) -> Value:
    """The initial value of a variable that is declared without (docs/language.md, "Variables").

    Raises:
        ValueError: a variable of this type holds nothing at the start.
    """
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


def example(type_: Type) -> Any:
    """The value of a parameter that has none: an array has one element."""
    match type_:
        case ArrayType(element=element):
            return (completed(None, element),)
    return completed(None, type_)


def completed(value: Any, type_: Type) -> Any:
    """The value of a parameter with the defaults of the fields that it leaves out."""
    match type_:
        case ArrayType(element=element):
            return tuple(completed(part, element) for part in value or ())
        case ObjectType(properties=properties):
            given = value or {}
            return {name: completed(given.get(name), inner) for name, inner in properties}
    return default_value(type_) if value is None else value
