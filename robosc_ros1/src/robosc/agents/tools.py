"""What an agent may ask of a robot: a tool for each command, and for each call that is served.

The arguments of a tool are the fields of its message, described as JSON Schema.
"""

from __future__ import annotations

import re
from collections.abc import Iterator, Mapping
from typing import Any

from robosc.emit.supervisor.command_recognition import command_matches
from robosc.expr import types
from robosc.language import events, tokens
from robosc.lazy_dataclasses import dataclass
from robosc.model.entities import Communication, Robot
from robosc.source import Source, Span

Json = Any

OWN = ("state", "why", "what_if", "cancel", "play")
"""The names of the server's own tools."""

WHOLE = "value"
"""The argument of a tool whose message has one field, or none that the model names."""

_COMMANDS = (events.Kind.INCOMING, events.Kind.SERVICE, events.Kind.ACTION)
_SERVED = (events.Kind.SERVED_SERVICE, events.Kind.SERVED_ACTION)
_WORDS = {
    events.Kind.INCOMING: "Send the command",
    events.Kind.SERVICE: "Call the service",
    events.Kind.ACTION: "Start the action",
    events.Kind.SERVED_SERVICE: "Ask the controller for",
    events.Kind.SERVED_ACTION: "Give the controller the order",
}


@dataclass(frozen=True)
class Tool:
    """A command of the supervised side, or a call that the controller serves.

    ``title`` is the model's name for it. ``data`` are the values of a command that always carries
    the same ones; it takes no arguments. ``alike`` are the names of all commands of its topic: a
    supervisor knows only by the data which one a message is.
    """

    name: str
    title: str
    communication: Communication
    description: str
    schema: Json
    data: Mapping[str, object] | None
    alike: tuple[str, ...]

    @property
    def key(self) -> str:
        return self.communication.key

    @property
    def is_action(self) -> bool:
        return self.communication.kind in (events.Kind.ACTION, events.Kind.SERVED_ACTION)


def tools(robot: Robot) -> tuple[Tool, ...]:
    """Return the tools of a robot: what a guarded controller may send, or what the controller
    serves.

    Raises:
        ModelError: messages of one topic cannot be distinguished by their data.
    """
    guarded = robot.supervises
    fixed = _fixed(robot) if guarded else {}
    taken = set(OWN)
    found = []
    for communication in robot.communications.values():
        if (communication.kind in _COMMANDS) if guarded else (communication.kind in _SERVED):
            title = robot.display_names[communication.key]
            name = _unique(title, taken)
            data = fixed.get(communication.key)
            schema = _arguments(types.NoneType() if data is not None else communication.request)
            text = "\n".join(_description(robot, communication, guarded))
            alike = tuple(
                robot.display_names[c.key]
                for c in robot.communications.values()
                if (c.kind, c.ros_name) == (communication.kind, communication.ros_name)
            )
            found.append(Tool(name, title, communication, text, schema, data, alike))
    return tuple(found)


def _fixed(robot: Robot) -> dict[str, Mapping[str, object]]:
    """The data of the commands that always carry the same, by key."""
    matches = (m for found in command_matches(robot).values() for m in found)
    return {match.key: match.exact[0] for match in matches if len(match.exact) == 1}


def _unique(name: str, taken: set[str]) -> str:
    """A name as the protocol takes it, not used before."""
    plain = re.sub(r"[^A-Za-z0-9_-]+", "_", name).strip("_")[:60] or "command"
    found, number = plain, 1
    while found in taken:
        number += 1
        found = f"{plain}_{number}"
    taken.add(found)
    return found


# --- descriptions --------------------------------------------------------------------------------


def _description(robot: Robot, communication: Communication, guarded: bool) -> Iterator[str]:
    name = robot.display_names[communication.key]
    yield f"{_WORDS[communication.kind]} '{name}' of the robot {robot.name}."
    if comment := comment_of(communication.span):
        yield comment
    if guarded:
        rules = [r for r in robot.requirements if communication.key in r.communications]
        rules = [r for r in rules if r.concerns(events.EventKind.REQUEST) and not r.implied]
        if rules:
            yield "It is blocked unless these requirements hold:"
            yield from (f"- {rule.text}" for rule in rules)
    if communication.kind in (events.Kind.ACTION, events.Kind.SERVED_ACTION):
        yield "It takes a while: progress is reported, and the call ends when the action has ended."


def comment_of(span: Span) -> str:
    """Return the comment beside a declaration, on its line or directly above it; "": none.

    Models note units and meanings there.
    """
    source = span.source
    lines = source.text.splitlines()
    own = dict(_comments(source))
    if span.line in own:
        return own[span.line]
    above: list[str] = []
    number = span.line - 1
    while number in own and lines[number - 1].lstrip().startswith(("//", "/*")):
        above.insert(0, own[number])
        number -= 1
    return " ".join(above)


def _comments(source: Source) -> Iterator[tuple[int, str]]:
    for comment in tokens.tokenize(source).comments:
        text = comment.text.removeprefix("//").removeprefix("/*").removesuffix("*/")
        yield source.text.count("\n", 0, comment.start) + 1, " ".join(text.split())


# --- schemas -------------------------------------------------------------------------------------


def _arguments(type_: types.Type) -> Json:
    """The arguments of a tool as JSON Schema: an object, as the protocol asks."""
    match type_:
        case types.NoneType():
            return {"type": "object", "properties": {}, "additionalProperties": False}
        case types.ObjectType():
            return _schema(type_)
    return {
        "type": "object",
        "properties": {WHOLE: _schema(type_)},
        "required": [WHOLE],
        "additionalProperties": False,
    }


def _schema(type_: types.Type) -> Json:
    """A type as JSON Schema. Fields that are left out keep their defaults in ROS."""
    match type_:
        case types.BooleanType():
            return {"type": "boolean"}
        case types.IntegerType(bounds=bounds):
            limits = {} if bounds is None else {"minimum": bounds[0], "maximum": bounds[1]}
            return {"type": "integer", **limits}
        case types.StringType():
            return {"type": "string"}
        case types.EnumType(values=values):
            return {"enum": list(values)}
        case types.ArrayType(element=element):
            return {"type": "array", "items": _schema(element)}
        case types.ObjectType(properties=properties):
            return {
                "type": "object",
                "properties": {name: _schema(part) for name, part in properties},
                "additionalProperties": False,
            }
    return {"type": "number"}
