"""Expected types: which types an expression at some place may have."""

from __future__ import annotations

from collections.abc import Callable

from robosc.expr import types
from robosc.language.operators import Operand
from robosc.lazy_dataclasses import dataclass
from robosc.model.typing.compatibility import accepts, comparable, describe, is_basic


@dataclass(frozen=True)
class ExpectedType:
    """The types that a place accepts: as text, as a predicate, and as a type if it is only one."""

    text: str
    accepts: Callable[[types.Type], bool]
    type: types.Type | None = None


ANY = ExpectedType("a value", lambda _: True)
BOOLEAN = ExpectedType("a boolean", lambda t: isinstance(t, types.BooleanType), types.BooleanType())
_NEEDS = {
    Operand.ANY: ANY,
    Operand.BOOLEAN: BOOLEAN,
    Operand.NUMBER: ExpectedType("a number", types.is_number),
    Operand.INTEGER: ExpectedType("an integer", lambda t: isinstance(t, types.IntegerType)),
    Operand.BASIC: ExpectedType(
        "a value of a basic type or an enum", lambda t: is_basic(t) or isinstance(t, types.EnumType)
    ),
    Operand.ARRAY: ExpectedType("an array", lambda t: isinstance(t, types.ArrayType)),
    Operand.SUMMAND: ExpectedType(
        "a number or a string", lambda t: types.is_number(t) or isinstance(t, types.StringType)
    ),
}


def needs_of(operand: Operand) -> ExpectedType:
    """The expected type of an operand of an operator or a function."""
    return _NEEDS[operand]


def expected_type(target: types.Type) -> ExpectedType:
    """The expected type of a value for something that is declared as ``target``."""
    return ExpectedType(describe(target), lambda given: accepts(target, given), target)


def equal_to(type_: types.Type) -> ExpectedType:
    """The expected type of a value that is compared with one of ``type_``."""
    text = "a number" if types.is_number(type_) else describe(type_)
    return ExpectedType(text, lambda given: comparable(type_, given), type_)
