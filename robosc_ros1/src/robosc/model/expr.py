"""Resolved, typed expressions: shared by the model, the plant, guards and generated code.

Names are resolved to what they mean, and each node knows its type. Equality ignores spans, so equal
expressions compare equal wherever they were written.

Meaning of the operators: booleans and integers exactly as in Python (integers without bounds);
``/`` is IEEE 754 division to double (x/0 is an infinity or NaN, never an error); ``=`` on numbers
compares values (1 = 1.0); ``=>`` is implication.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, field
from typing import TypeAlias

from robosc.model.types import BooleanType, Type, Value
from robosc.source import Span

__all__ = [
    "FALSE", "TRUE", "Binary", "Expr", "Literal", "PhaseRef", "StateRef", "Unary", "ValueRef",
    "VariableRef", "walk",
]  # fmt: skip


@dataclass(frozen=True, slots=True)
class Literal:
    """A constant; for an enum type the value is the enum value's name."""

    value: Value
    type: Type
    span: Span | None = field(default=None, compare=False, repr=False)

    def __eq__(self, other: object) -> bool:
        return (
            isinstance(other, Literal)
            and type(self.value) is type(other.value)
            and self.value == other.value
            and self.type == other.type
        )

    def __hash__(self) -> int:
        return hash((type(self.value), self.value))


@dataclass(frozen=True, slots=True)
class VariableRef:
    """The current value of a component's variable."""

    component: str
    variable: str
    type: Type
    span: Span | None = field(default=None, compare=False, repr=False)


@dataclass(frozen=True, slots=True)
class StateRef:
    """True while the component is in that state."""

    component: str
    state: str
    span: Span | None = field(default=None, compare=False, repr=False)

    @property
    def type(self) -> Type:
        return BooleanType()


@dataclass(frozen=True, slots=True)
class PhaseRef:
    """True while a service or action (by key) is busy. Users cannot write it; synthesis can."""

    communication: str
    span: Span | None = field(default=None, compare=False, repr=False)

    @property
    def type(self) -> Type:
        return BooleanType()


@dataclass(frozen=True, slots=True)
class ValueRef:
    """What came in (``value``), or a part of it: member names and array indexes after ``value``."""

    path: tuple[str | int, ...]
    type: Type
    span: Span | None = field(default=None, compare=False, repr=False)


@dataclass(frozen=True, slots=True)
class Unary:
    """``!`` or ``-``."""

    operator: str
    operand: Expr
    type: Type
    span: Span | None = field(default=None, compare=False, repr=False)


@dataclass(frozen=True, slots=True)
class Binary:
    """``=> or and = != < <= > >= + - * /``."""

    operator: str
    left: Expr
    right: Expr
    type: Type
    span: Span | None = field(default=None, compare=False, repr=False)


Expr: TypeAlias = Literal | VariableRef | StateRef | PhaseRef | ValueRef | Unary | Binary

TRUE = Literal(True, BooleanType())
FALSE = Literal(False, BooleanType())


def walk(expr: Expr) -> Iterator[Expr]:
    """The expression and all its parts, in source order, without recursion."""
    stack = [expr]
    while stack:
        node = stack.pop()
        yield node
        match node:
            case Unary(operand=operand):
                stack.append(operand)
            case Binary(left=left, right=right):
                stack.append(right)
                stack.append(left)
