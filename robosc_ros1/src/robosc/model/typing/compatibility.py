"""Rules about types: texts for messages, compatibility, results, and ranges of constants."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from robosc.expr import evaluation, tree, types
from robosc.language.operators import Result
from robosc.model.diagnostics import Report


def describe(type_: types.Type) -> str:
    """The text for a value of a type in messages: ``a boolean``, ``a value of Distance``."""
    match type_:
        case types.NoneType():
            return "none"
        case types.IntegerType():
            return f"an {type_}"
        case types.ArrayType():
            return f"an {type_}"
        case types.EnumType(name=name):
            return f"a value of {name}"
        case types.ObjectType(name=name):
            return f"an object {name}"
    return f"a {type_}"


def result_type(result: Result, operands: Sequence[types.Type]) -> types.Type:
    """The type of an operation's result."""
    match result:
        case Result.BOOLEAN:
            return types.BooleanType()
        case Result.NUMBER if all(isinstance(type_, types.IntegerType) for type_ in operands):
            return types.IntegerType()
        case Result.INTEGER:
            return types.IntegerType()
        case Result.STRING:
            return types.StringType()
        case Result.SAME if len(set(operands)) == 1:
            return operands[0]
        case Result.SAME:  # of two ranges
            return types.IntegerType()
        case Result.SUM:
            left = next(iter(operands))
            return left if left == types.StringType() else result_type(Result.NUMBER, operands)
    return types.DoubleType()


def type_of(value: types.Value) -> types.Type:
    """The type of a plain value; a str is taken as a string, not as the value of an enum."""
    match value:
        case bool():
            return types.BooleanType()
        case int():
            return types.IntegerType()
        case float():
            return types.DoubleType()
    return types.StringType()


def is_basic(type_: types.Type) -> bool:
    """Whether a type is boolean, integer, double or string."""
    return isinstance(
        type_, types.BooleanType | types.IntegerType | types.DoubleType | types.StringType
    )


def accepts(target: types.Type, given: types.Type) -> bool:
    """Whether a value of type ``given`` may be used where ``target`` is declared.

    Ranges are ignored: constants are checked by :func:`check_range`, all else by synthesis.
    """
    match target, given:
        case (types.IntegerType(), types.IntegerType()):
            return True
        case (types.DoubleType(), _):
            return types.is_number(given)
    return target == given


def comparable(left: types.Type, right: types.Type) -> bool:
    """Whether ``=`` may compare two types: equal ones, and any two types of numbers."""
    if types.is_number(left) and types.is_number(right):
        return True
    return left == right and not isinstance(
        left, types.ArrayType | types.ObjectType | types.NoneType | types.DurationType
    )


def coerce(expr: tree.Expr, target: types.Type) -> tree.Expr:
    """The expression; an integer literal becomes a double if the target is one."""
    if (
        isinstance(target, types.DoubleType)
        and isinstance(expr, tree.Literal)
        and type(expr.value) is int
    ):
        return tree.Literal(float(expr.value), target, expr.span)
    return expr


def check_range(expr: tree.Expr, target: types.Type, what: str, report: Report) -> None:
    """Report a constant outside the bounds of a ranged integer."""
    if not isinstance(target, types.IntegerType) or target.bounds is None or expr.span is None:
        return
    value = evaluation.constant(expr)
    low, high = target.bounds
    if type(value) is int and not low <= value <= high:
        report.add(
            "out-of-range",
            expr.span,
            f"{value} is outside the range of {what}",
            f"{target} takes {low} to {high}",
        )


def default_value(type_: types.Type) -> types.Value:
    """The initial value of a variable that is declared without (docs/language.md, "Variables").

    Raises:
        ValueError: a variable of this type holds nothing at the start.
    """
    match type_:
        case types.BooleanType():
            return False
        case types.IntegerType(bounds=None):
            return 0
        case types.IntegerType(bounds=(low, high)):
            return min(max(0, low), high)
        case types.DoubleType():
            return 0.0
        case types.StringType():
            return ""
        case types.EnumType(default=default):
            return default
    raise ValueError(f"no variable can be {describe(type_)}")


def example(type_: types.Type) -> Any:
    """The value of a parameter that has none: an array has one element."""
    match type_:
        case types.ArrayType(element=element):
            return (completed(None, element),)
    return completed(None, type_)


def completed(value: Any, type_: types.Type) -> Any:
    """The value of a parameter with the defaults of the fields that it leaves out."""
    match type_:
        case types.ArrayType(element=element):
            return tuple(completed(part, element) for part in value or ())
        case types.ObjectType(properties=properties):
            given = value or {}
            return {name: completed(given.get(name), inner) for name, inner in properties}
    return default_value(type_) if value is None else value
