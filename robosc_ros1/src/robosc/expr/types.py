"""The resolved types of the language (docs/language.md, "Types").

Values are Python's bool, int, float and str; the value of an enum is the str of its name. None
stands for "no value".
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import field
from typing import TypeAlias

from robosc.lazy_dataclasses import dataclass

Value: TypeAlias = bool | int | float | str


@dataclass(frozen=True, slots=True)
class NoneType:
    """``none``: the type of a communication without data."""

    def __str__(self) -> str:
        return "none"


@dataclass(frozen=True, slots=True)
class BooleanType:
    """``boolean``."""

    def __str__(self) -> str:
        return "boolean"


@dataclass(frozen=True, slots=True)
class StringType:
    """``string``."""

    def __str__(self) -> str:
        return "string"


@dataclass(frozen=True, slots=True)
class DoubleType:
    """``double``."""

    def __str__(self) -> str:
        return "double"


@dataclass(frozen=True, slots=True)
class DurationType:
    """``duration``, for constants and parameters only; a value is a double in seconds."""

    def __str__(self) -> str:
        return "duration"


@dataclass(frozen=True, slots=True)
class IntegerType:
    """``integer`` without bounds, or ``integer(low..high)``, both bounds inclusive."""

    bounds: tuple[int, int] | None = None

    def __str__(self) -> str:
        return "integer" if self.bounds is None else f"integer({self.bounds[0]}..{self.bounds[1]})"


@dataclass(frozen=True, slots=True)
class ArrayType:
    """``array(element)``, of any length."""

    element: Type

    def __str__(self) -> str:
        return f"array({self.element})"


@dataclass(frozen=True, slots=True)
class EnumRule:
    """``condition -> value``.

    ``condition`` is an expression, whose class this module cannot import: use
    :func:`robosc.expr.tree.condition_of`.
    """

    condition: object
    value: str


@dataclass(frozen=True, slots=True)
class EnumType:
    """A finite type to which rules map received values; the first rule that holds decides.

    If none holds, the value is ``default``. Two enums are the same type if name and origin (the
    robot or library that declares them) are equal. ``values`` are in order of first appearance.
    """

    name: str
    origin: str
    source: Type = field(compare=False)
    values: tuple[str, ...] = field(compare=False)
    default: str = field(compare=False)
    rules: tuple[EnumRule, ...] = field(compare=False, repr=False)

    def __str__(self) -> str:
        return self.name


@dataclass(frozen=True, slots=True)
class ObjectType:
    """Named fields of a ROS message, service or action, in the order of the declaration.

    Two objects are the same type if name and origin are equal.
    """

    name: str
    origin: str
    properties: tuple[tuple[str, Type], ...] = field(compare=False)

    def __str__(self) -> str:
        return self.name

    def property(self, name: str) -> Type | None:
        """The type of a property; None if there is no such property."""
        return dict(self.properties).get(name)


Type: TypeAlias = (
    NoneType
    | BooleanType
    | StringType
    | DoubleType
    | DurationType
    | IntegerType
    | ArrayType
    | EnumType
    | ObjectType
)


TYPES_BY_WORD: Mapping[str, Type] = {
    str(type_): type_
    for type_ in (StringType(), BooleanType(), DoubleType(), IntegerType(), NoneType())
}
"""The types that are one word of the language."""


def is_number(type_: Type) -> bool:
    """Whether a type is integer or double."""
    return isinstance(type_, IntegerType | DoubleType)


def innermost(type_: Type, path: tuple[str, ...] = ()) -> Iterator[tuple[tuple[str, ...], Type]]:
    """What arrays and objects consist of, or the type itself, after the fields it is in."""
    match type_:
        case ArrayType(element=element):
            yield from innermost(element, path)
        case ObjectType(properties=properties):
            for name, inner in properties:
                yield from innermost(inner, (*path, name))
        case _:
            yield path, type_


def domain(type_: Type) -> Sequence[Value] | None:
    """The values of a finite type in order (false before true; a range for integers), else None."""
    match type_:
        case BooleanType():
            return (False, True)
        case IntegerType(bounds=(low, high)):
            return range(low, high + 1)
        case EnumType(values=values):
            return values
    return None
