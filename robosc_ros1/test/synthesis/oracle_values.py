"""Values and expressions as the oracle reads them, in plain Python."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from contextlib import suppress
from functools import partial
from typing import Any

from robosc.expr.tree import (
    Aggregate,
    Binary,
    Call,
    Convert,
    ElementRef,
    Expr,
    Holds,
    Literal,
    ParameterRef,
    PhaseRef,
    StateRef,
    Unary,
    ValueRef,
    VariableRef,
)
from robosc.expr.types import ArrayType, BooleanType, EnumType, IntegerType, ObjectType, Type

Path = tuple[str | int, ...]
Samples = Mapping[Type, Sequence[Any]]


class UndefinedValue(Exception):
    """An array was shorter than an index that an expression uses."""


class OutOfRange(Exception):
    """An assignment leaves the range of its variable."""


class Impossible(Exception):
    """The plant cannot do the event in this state."""


def evaluate(expr: Expr, read: Any) -> Any:
    """The value of an expression; ``read`` gives that of a reference, or raises UndefinedValue."""
    match expr:
        case Literal(value=value):
            return value
        case VariableRef() | StateRef() | PhaseRef() | ParameterRef() | ValueRef() | ElementRef():
            return read(expr)
        case Unary(operator="!", operand=operand):
            return not evaluate(operand, read)
        case Unary(operator="-", operand=operand):
            return -evaluate(operand, read)
        case Binary(operator="and", left=left, right=right):
            return evaluate(left, read) and evaluate(right, read)
        case Binary(operator="or", left=left, right=right):
            return evaluate(left, read) or evaluate(right, read)
        case Binary(operator="=>", left=left, right=right):
            return not evaluate(left, read) or evaluate(right, read)
        case Binary(operator="else", left=left, right=right):
            with suppress(UndefinedValue):
                value = evaluate(left, read)
                if str(value) != "nan":
                    return value
            return evaluate(right, read)
        case Holds(operand=operand):
            with suppress(UndefinedValue):
                return evaluate(operand, read) is not False
            return False
        case Binary(operator=operator, left=left, right=right):
            return apply(operator, evaluate(left, read), evaluate(right, read))
        case Convert(argument=argument, type=enum):
            return convert(enum, evaluate(argument, read))
        case Call(operator="length", operands=(array,)):
            return len(evaluate(array, read))
        case Aggregate():
            return aggregate(expr, read)
    raise TypeError(expr)


def aggregate(expr: Aggregate, read: Any) -> Any:
    """What goes through an array: of elements for which something is undefined, nothing counts."""
    found = []
    for place, item in enumerate(evaluate(expr.array, read)):
        inside = partial(_element, {expr.variable: item, expr.position: place}, read)
        kept = expr.condition is None
        with suppress(UndefinedValue):
            kept = kept or evaluate(expr.condition, inside)
        if kept and expr.operator == "[":
            found.append(evaluate(expr.element, inside))
        elif kept:
            with suppress(UndefinedValue):
                found.append(evaluate(expr.element, inside))
    match expr.operator:
        case "[":
            return found
        case "first" if found:
            return found[0]
        case "any":
            return any(found)
        case "all":
            return all(found)
        case "count":
            return sum(1 for result in found if result)
        case "sum":
            return sum(found)
    found = [number for number in found if str(number) != "nan"]
    if not found:
        raise UndefinedValue
    return min(found) if expr.operator == "min" else max(found)


def _element(items: Mapping[str, Any], read: Any, part: Expr) -> Any:
    """A reference inside of an aggregate over plain numbers."""
    if isinstance(part, ElementRef) and part.variable in items:
        assert part.path == ()
        return items[part.variable]
    return read(part)


def convert(enum: EnumType, value: Any) -> str:
    """The value of the first rule that holds, or the default."""
    for rule in enum.rules:
        with suppress(UndefinedValue):
            if evaluate(rule.condition, lambda part: value):
                return rule.value
    return enum.default


def apply(operator: str, left: Any, right: Any) -> Any:
    match operator:
        case "=":
            return left == right
        case "!=":
            return left != right
        case "<":
            return left < right
        case "<=":
            return left <= right
        case ">":
            return left > right
        case ">=":
            return left >= right
        case "+":
            return left + right
        case "-":
            return left - right
        case "*":
            return left * right
        case "/":
            return divide(float(left), float(right))
        case "%":
            return remainder(left, right)
    raise ValueError(operator)


def remainder(left: Any, right: Any) -> Any:
    """What is left of a division downwards; an integer is not divided by 0."""
    if right == 0:
        return left if isinstance(left, int) and isinstance(right, int) else math.nan
    return left - right * (left // right) if isinstance(left + right, int) else left % right


def divide(left: float, right: float) -> float:
    """IEEE 754 division."""
    if right != 0:
        return left / right
    if left == 0 or math.isnan(left):
        return math.nan
    return math.copysign(math.inf, left) * math.copysign(1.0, right)


def values_of(type_: Type, path: Path, samples: Samples) -> list[Any]:
    """All values at a path of an incoming value; None last where an array may be too short.

    Of a type that is not finite, those of ``samples``.
    """
    through_array = False
    for step in path:
        match type_:
            case ObjectType():
                assert isinstance(step, str)
                found = type_.property(step)
                assert found is not None
                type_ = found
            case ArrayType(element=element):
                through_array = True
                type_ = element
            case _:
                raise TypeError(f"{step} of {type_}")
    match type_:
        case BooleanType():
            values: list[Any] = [False, True]
        case IntegerType(bounds=(low, high)):
            values = list(range(low, high + 1))
        case EnumType(values=names):
            values = list(names)
        case _:
            values = list(samples[type_])
    return [*values, None] if through_array else values
