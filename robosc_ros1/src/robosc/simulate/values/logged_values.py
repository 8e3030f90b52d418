"""The values of events in a log: from JSON to those that the controller takes."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

from robosc.expr import types
from robosc.expr.traversal import all_names, path_text
from robosc.model.entities import Robot
from robosc.model.typing.compatibility import describe
from robosc.plant import automaton, event_values
from robosc.simulate.faults import InvalidLine
from robosc.simulate.values.typed_values import typed_value, within_whole
from robosc.supervisor import Supervisor


@dataclass(frozen=True)
class LoggedPart:
    """A part of an input's value, which may be missing if it is ``optional``."""

    type: types.Type
    optional: bool

    def restored(self, told: Any) -> Any:
        """The value from JSON.

        Raises:
            ValueError: it is not of the type.
        """
        if told is None and self.optional:
            return None
        try:
            value = typed_value(self.type, _of_type(self.type, told), "it")
        except InvalidLine:
            value = None
        values = types.domain(self.type)
        if value is None or (values is not None and told not in values):
            raise ValueError(f"it carries {describe(self.type)}")
        return value


def _of_type(type_: types.Type, told: Any) -> Any:
    """The members that the model declares: a whole message is logged with all of them.

    Raises:
        InvalidLine: one is not there.
    """
    match within_whole(type_), told:
        case types.ArrayType(element=element), list():
            return [_of_type(element, item) for item in told]
        case types.ObjectType(properties=properties), dict():
            if missing := [name for name, _ in properties if name not in told]:
                raise InvalidLine(f"{missing[0]} is missing")
            return {name: _of_type(inner, told[name]) for name, inner in properties}
    return told


def carried_parts(supervisor: Supervisor) -> dict[tuple[str, str], dict[str, LoggedPart]]:
    """By communication and kind, the parts of an input's value; that of a whole one is ``""``."""
    robot = supervisor.plant.robot
    return {
        (event.key, event.kind.word): _parts(robot, event)
        for event in supervisor.plant.events
        if not isinstance(event_values.value_type(robot, event), types.NoneType)
    }


def _parts(robot: Robot, event: automaton.Event) -> dict[str, LoggedPart]:
    optional = event_values.is_optional(robot, event)
    parts = event_values.value_parts(robot, event).items()
    return {path_text(p): LoggedPart(t, optional or not all_names(p)) for p, t in parts}


def restored_value(told: Any, parts: dict[str, LoggedPart]) -> Any:
    """The value of an input from JSON, if it is one of these types.

    Raises:
        ValueError: it is not.
    """
    if not parts:
        return None
    if "" in parts and not isinstance(parts[""].type, types.ObjectType):
        return parts[""].restored(told)
    if not isinstance(told, dict) or set(told) != set(parts):
        raise ValueError(f"it has the parts {', '.join(parts)}")
    return {path: part.restored(told[path]) for path, part in parts.items()}
