"""The interfaces of ROS packages: messages, services and actions, with fields and constants."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from typing import Literal, TypeAlias

from robosc.expr.types import Value
from robosc.lazy_dataclasses import dataclass

Folder: TypeAlias = Literal["msg", "srv", "action"]
"""The folder of a package's messages, services or actions; also part of type names in ROS 2."""

KINDS: Mapping[Folder, str] = {"msg": "message", "srv": "service", "action": "action"}
"""The kind of interface in each folder, in words."""

PARTS: Mapping[Folder, tuple[str, ...]] = {
    "msg": ("",),
    "srv": ("Request", "Response"),
    "action": ("Goal", "Result", "Feedback"),
}
"""The parts of the interfaces in each folder, as the names of their definitions end."""

INTEGERS: Mapping[str, tuple[int, int]] = {
    **{f"int{bits}": (-(2 ** (bits - 1)), 2 ** (bits - 1) - 1) for bits in (8, 16, 32, 64)},
    **{f"uint{bits}": (0, 2**bits - 1) for bits in (8, 16, 32, 64)},
    "byte": (-128, 127),
    "char": (0, 255),
}
"""The least and greatest value of each integer type; byte and char are int8 and uint8 in ROS 1."""

WORDS: Mapping[str, str] = {
    **dict.fromkeys(INTEGERS, "integer"), "bool": "boolean", "string": "string",
    "float32": "double", "float64": "double",
}  # fmt: skip
"""The type of the language for each built-in type but points in time and durations."""


@dataclass(frozen=True, slots=True)
class FieldType:
    """The type of a field: ``base`` is a built-in type or ``package/Type``.

    ``length`` is that of an array of fixed length, else None; ``wide`` says that a string is one of
    wide characters, which is packed in another way. ``most`` elements may be in an array, and so
    many characters in each string as ``longest``, which ROS 2 can demand.
    """

    base: str
    is_array: bool = False
    length: int | None = None
    wide: bool = False
    most: int | None = None
    longest: int | None = None

    def __str__(self) -> str:
        if not self.is_array:
            return self.base
        return f"{self.base}[{'' if self.length is None else self.length}]"

    @property
    def element(self) -> FieldType:
        return FieldType(self.base, wide=self.wide, longest=self.longest)

    @property
    def is_message(self) -> bool:
        return "/" in self.base or self.base in ("time", "duration")


Default = Value | tuple[Value, ...]
"""What a field is where none is given; of an array a tuple."""


@dataclass(frozen=True, slots=True)
class Field:
    """A field of a message; ``default`` None: zero or empty."""

    name: str
    type: FieldType
    default: Default | None = None

    @property
    def elements(self) -> int:
        """The number of elements of an array that nobody gives."""
        return len(self.default) if isinstance(self.default, tuple) else self.type.length or 0

    def element(self, index: int) -> Field:
        """An element of an array, with what it is where nobody gives the array."""
        given = isinstance(self.default, tuple) and -self.elements <= index < self.elements
        return Field(self.name, self.type.element, self.default[index] if given else None)  # type: ignore[index]


@dataclass(frozen=True, slots=True)
class Definition:
    """The fields and constants of a message, or of one part of a service or action. ``doubts`` are
    what can be understood, but ROS refuses when it builds the package."""

    name: str
    fields: tuple[Field, ...]
    constants: tuple[tuple[str, Value], ...] = ()
    doubts: tuple[str, ...] = ()

    @classmethod
    def of(
        cls,
        name: str,
        fields: Iterable[tuple[str, str] | tuple[str, str, Default | None]],
        constants: Iterable[tuple[str, Value]] = (),
        doubts: Iterable[str] = (),
    ) -> Definition:
        """The definition with fields of these names and types, such as ``float64[3]`` or
        ``string<=8[<=3]``, and defaults."""
        found = tuple(Field(f, _field_type(t), *default) for f, t, *default in fields)
        return cls(name, found, tuple(constants), tuple(doubts))

    def field(self, name: str) -> Field | None:
        return next((f for f in self.fields if f.name == name), None)

    def constant(self, name: str) -> Value | None:
        return dict(self.constants).get(name)


@dataclass(frozen=True, slots=True)
class Interface:
    """The definition of a message (one part), service (two) or action (three).

    ``type`` is the stem of the file, without the suffix ``Action`` that the model may add.
    """

    package: str
    type: str
    parts: tuple[Definition, ...]


@dataclass(frozen=True, slots=True)
class Missing:
    """The reason why a definition is not available.

    ``reason`` is ``package`` (there is none of that name), ``file`` (it has no such file; ``names``
    are those that it has) or ``faulty`` (the file cannot be read; ``detail`` says why).
    """

    reason: str
    package: str
    names: tuple[str, ...] = ()
    detail: str = ""


def _field_type(text: str) -> FieldType:
    element, bracket, length = text.rstrip("]").partition("[")
    most = int(length[2:]) if length.startswith("<=") else None
    fixed = int(length) if length and most is None else None
    base, _, longest = element.partition("<=")
    wide = base == "wstring"
    base = "string" if wide else base
    return FieldType(base, bool(bracket), fixed, wide, most, int(longest) if longest else None)
