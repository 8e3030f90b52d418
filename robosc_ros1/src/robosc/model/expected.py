"""What a place needs of the expression that stands there."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

from robosc.language.operators import Operand
from robosc.model.compatibility import accepts, comparable, describe, is_basic
from robosc.model.types import (
    ArrayType,
    BooleanType,
    EnumType,
    IntegerType,
    StringType,
    Type,
    is_number,
)

__all__ = ["ANY", "BOOLEAN", "ExpectedType", "equal_to", "expected_type", "needs_of"]


@dataclass(frozen=True)
class ExpectedType:
    """What a place needs: in words, as a test, and as a type where it is exactly one."""

    text: str
    accepts: Callable[[Type], bool]
    type: Type | None = None


ANY = ExpectedType("a value", lambda _: True)
BOOLEAN = ExpectedType("a boolean", lambda t: isinstance(t, BooleanType), BooleanType())
_NEEDS = {
    Operand.ANY: ANY,
    Operand.BOOLEAN: BOOLEAN,
    Operand.NUMBER: ExpectedType("a number", is_number),
    Operand.INTEGER: ExpectedType("an integer", lambda t: isinstance(t, IntegerType)),
    Operand.BASIC: ExpectedType(
        "a value of a basic type or an enum", lambda t: is_basic(t) or isinstance(t, EnumType)
    ),
    Operand.ARRAY: ExpectedType("an array", lambda t: isinstance(t, ArrayType)),
    Operand.SUMMAND: ExpectedType(
        "a number or a string", lambda t: is_number(t) or isinstance(t, StringType)
    ),
}


def needs_of(operand: Operand) -> ExpectedType:
    """What an operator or a function needs of an operand."""
    return _NEEDS[operand]


def expected_type(target: Type) -> ExpectedType:
    """The needs of something declared as ``target``."""
    return ExpectedType(describe(target), lambda given: accepts(target, given), target)


def equal_to(type_: Type) -> ExpectedType:
    """The needs of what is compared with a value of a type."""
    text = "a number" if is_number(type_) else describe(type_)
    return ExpectedType(text, lambda given: comparable(type_, given), type_)
