"""Which fields have 32 bits, so that numbers do not arrive in them as they were written."""

from __future__ import annotations

import re
import struct
from typing import Any

from robosc.language.events import EventKind
from robosc.model.entities import Communication, Robot
from robosc.model.ros.definitions import MessageDefinitions
from robosc.model.ros.interfaces import Definition, FieldType, Missing
from robosc.plant.automaton import Event
from robosc.simulate.faults import InvalidLine
from robosc.traces.samples import Narrow

_PARTS = {
    EventKind.CALL: (0, "request_field"),
    EventKind.REQUEST: (0, "request_field"),
    EventKind.ANSWER: (1, "response_field"),
    EventKind.PROGRESS: (2, "feedback_field"),
    EventKind.RESPONSE: (1, "response_field"),
    EventKind.ERROR: (1, "response_field"),
    EventKind.FEEDBACK: (2, "feedback_field"),
}
"""By kind of event: the part of a definition that brings its value, and the only field."""


def narrowing(robot: Robot, definitions: MessageDefinitions) -> Narrow:
    """What becomes of a raw value on its way to the node. Fields of unknown types keep it."""

    def narrow(event: Event, raw: Any) -> Any:
        communication = robot.communications.get(event.key)
        if communication is None or event.kind not in _PARTS:
            return raw
        number, attribute = _PARTS[event.kind]
        found = definitions.interface(
            communication.binding.package, communication.binding.type, communication.sort.folder
        )
        if isinstance(found, Missing):
            return raw
        part = found.parts[min(number, len(found.parts) - 1)]
        return _narrowed(raw, part, _field(communication, attribute), definitions)

    return narrow


def _field(communication: Communication, attribute: str) -> str:
    return getattr(communication.binding, attribute) or ""


def _narrowed(raw: Any, part: Definition, field: str, definitions: MessageDefinitions) -> Any:
    if isinstance(raw, dict):
        return {path: _as_in(v, _base(part, path or field, definitions)) for path, v in raw.items()}
    return _as_in(raw, _base(part, field, definitions))


def _base(part: Definition, path: str, definitions: MessageDefinitions) -> FieldType | None:
    """The type of a field, or of the array of which it is an element; None if it is not known."""
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
        inner = definitions.fields(field.type.element)
        if not isinstance(inner, Definition):
            return None
        part = inner
    return None


def _as_in(value: Any, type_: FieldType | None) -> Any:
    """A value as it arrives in a field of this type. Raises InvalidLine if it cannot."""
    if type_ is None:
        return value
    if isinstance(value, list) and type_.length not in (None, len(value)):
        raise InvalidLine(f"{len(value)} elements do not fit {type_}")
    base = {"byte": "int8", "char": "uint8"}.get(type_.base, type_.base)
    if base == "float32":
        return _rounded(value)
    found = re.fullmatch(r"(u?)int(8|16|32|64)", base)
    for number in value if isinstance(value, list) else [value]:
        if found is None or not isinstance(number, int) or isinstance(number, bool):
            continue
        bits = int(found[2])
        low, high = (0, 2**bits) if found[1] else (-(2 ** (bits - 1)), 2 ** (bits - 1))
        if not low <= number < high:
            raise InvalidLine(f"{number} does not fit {base}")
    return value


def _rounded(value: Any) -> Any:
    if isinstance(value, list):
        return [_rounded(item) for item in value]
    if not isinstance(value, float):
        return value
    try:
        return float(struct.unpack("f", struct.pack("f", value))[0])
    except OverflowError:
        return value
