"""Which fields have 32 bits, so that numbers do not arrive in them as they were written."""

from __future__ import annotations

import re
import struct
from typing import Any

from robosc.language.events import EventKind
from robosc.model.entities import Communication, Robot
from robosc.model.ros.definitions import MessageDefinitions
from robosc.model.ros.interfaces import Definition, Missing
from robosc.plant.automaton import Event
from robosc.traces.samples import Narrow

_PARTS = {
    EventKind.CALL: (0, "request_field"),
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
        return {
            path: _rounded(v) if _is_narrow(part, path or field, definitions) else v
            for path, v in raw.items()
        }
    return _rounded(raw) if _is_narrow(part, field, definitions) else raw


def _is_narrow(part: Definition, path: str, definitions: MessageDefinitions) -> bool:
    names = re.findall(r"[A-Za-z_]\w*", path)
    for number, name in enumerate(names):
        field = part.field(name)
        if field is None:
            return False
        if number == len(names) - 1:
            return field.type.base == "float32"
        inner = definitions.fields(field.type.element)
        if not isinstance(inner, Definition):
            return False
        part = inner
    return False


def _rounded(value: Any) -> Any:
    if isinstance(value, list):
        return [_rounded(item) for item in value]
    if not isinstance(value, float):
        return value
    try:
        return float(struct.unpack("f", struct.pack("f", value))[0])
    except OverflowError:
        return value
