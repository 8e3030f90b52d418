"""What becomes of values in the fields of messages: some have 32 bits, some take not all values."""

from __future__ import annotations

import re
import struct
from collections.abc import Iterator
from typing import Any, TypeAlias

from robosc.expr.traversal import path_text
from robosc.model.entities import Robot
from robosc.model.ros.definitions import MessageDefinitions
from robosc.model.ros.interfaces import INTEGERS, Definition, FieldType
from robosc.model.ros.sent import carrier
from robosc.plant.automaton import Event
from robosc.plant.event_values import value_parts
from robosc.simulate.faults import InvalidLine

Path: TypeAlias = tuple[str | int, ...]


def parts_of(data: Any, path: tuple[str | int, ...] = ()) -> Iterator[tuple[Any, Any]]:
    """Nested data and all parts of them, by path."""
    yield path, data
    inner = (
        data.items()
        if isinstance(data, dict)
        else enumerate(data)
        if isinstance(data, list)
        else ()
    )
    for name, part in inner:
        yield from parts_of(part, (*path, name))


class Fields:
    """What becomes of raw values in the fields of messages: of these nothing is known."""

    def __init__(self) -> None:
        self.unknown: set[str] = set()
        """The messages that were asked for, and of which no definition was found."""

    def narrow(self, event: Event, raw: Any) -> Any:
        """A value as it arrives in the fields of an event's message.

        Raises:
            InvalidLine: it does not fit into them.
        """
        return raw

    def demand_whole(self, event: Event, raw: Any) -> None:
        """Demand what always arrives.

        Raises:
            InvalidLine: the value leaves out an element of an array of fixed length.
        """

    def demand_fitting(self, event: Event, data: Any) -> None:
        """Demand that the data of a command fit into the fields of its message.

        Raises:
            InvalidLine: they do not, so that they cannot be sent.
        """
        parts = {path_text(p): v for p, v in parts_of(data) if not isinstance(v, dict)}
        self.narrow(event, parts)


class KnownFields(Fields):
    """Fields of messages whose definitions are known; those of others keep what they get."""

    def __init__(self, robot: Robot, definitions: MessageDefinitions) -> None:
        super().__init__()
        self._robot, self._definitions = robot, definitions
        self._types: dict[Any, dict[str, FieldType | None]] = {}
        """Of each event, the types of its fields by path."""
        self._elements: dict[Any, list[Path]] = {}

    def narrow(self, event: Event, raw: Any) -> Any:
        if not isinstance(raw, dict):
            return _as_in(raw, self._type(event, ""))
        found = {}
        for path, value in raw.items():
            type_ = self._type(event, path)
            found[path] = value if type_ is None else _as_in(value, type_)
        return found

    def demand_whole(self, event: Event, raw: Any) -> None:
        if not isinstance(raw, dict) or event.kind.sent:
            return
        if event.identity not in self._elements:
            self._elements[event.identity] = [
                path for path in value_parts(self._robot, event) if self._arrives(event, path)
            ]
        for path in self._elements[event.identity]:
            around = {path_text(path[:end]) for end in range(1, len(path) + 1)}
            if not any(name in around or name.startswith(f"{path_text(path)}.") for name in raw):
                raise InvalidLine(f"{path_text(path)} always arrives")

    def _arrives(self, event: Event, path: Path) -> bool:
        """Whether a part is in arrays of fixed length, and in no others."""
        places = [(n, step) for n, step in enumerate(path) if isinstance(step, int)]
        types = [(self._type(event, path_text(path[:n])), step) for n, step in places]
        lengths = [(None if type_ is None else type_.length, step) for type_, step in types]
        return bool(places) and all(n is not None and step < n for n, step in lengths)

    def _type(self, event: Event, path: str) -> FieldType | None:
        """The type of a field, or of the array of which it is an element."""
        known = self._types.setdefault(event.identity, {})
        if path not in known:
            known[path] = self._found(event, path)
        return known[path]

    def _found(self, event: Event, path: str) -> FieldType | None:
        communication = self._robot.communications.get(event.key)
        sort = None if communication is None else communication.sort.event(event.kind)
        if communication is None or sort is None or sort.brings is None:
            return None
        binding = communication.binding
        part = carrier(self._definitions, communication, sort.brings)
        if part is None:
            self.unknown.add(f"{binding.package}/{binding.type}")
            return None
        return self._base(part, path or getattr(binding, f"{sort.brings}_field") or "")

    def _base(self, part: Definition, path: str) -> FieldType | None:
        """The type of a field, or of the array of which it is an element."""
        names = re.findall(r"[A-Za-z_]\w*", path)
        for number, name in enumerate(names):
            field = part.field(name)
            if field is None:
                return None
            base = str(field.type.base)
            if number == len(names) - 1:
                return field.type
            if base in ("time", "duration"):
                return FieldType("uint32" if base == "time" else "int32")
            inner = self._definitions.fields(field.type.element)
            if not isinstance(inner, Definition):
                self.unknown.add(base)
                return None
            part = inner
        return None


def _as_in(value: Any, type_: FieldType | None) -> Any:
    """A value as it arrives in a field of this type."""
    if type_ is None:
        return value
    if isinstance(value, list):
        most = len(value) if type_.most is None else type_.most
        if type_.length not in (None, len(value)) or len(value) > most:
            raise InvalidLine(f"{len(value)} elements do not fit {type_}")
        return [_as_in(item, type_.element) for item in value]
    bounds = INTEGERS.get(type_.base)
    if isinstance(value, str):
        if type_.longest is not None and len(value) > type_.longest:
            raise InvalidLine(f"{value!r} is longer than {type_.longest}")
    elif type_.base == "float32" and isinstance(value, float):
        return _rounded(value)
    elif bounds and isinstance(value, int) and not bounds[0] <= int(value) <= bounds[1]:
        raise InvalidLine(f"{value} does not fit {type_}")
    return value


def _rounded(value: float) -> float:
    try:
        return float(struct.unpack("<f", struct.pack("<f", value))[0])
    except OverflowError:
        raise InvalidLine(f"{value} does not fit float32") from None
