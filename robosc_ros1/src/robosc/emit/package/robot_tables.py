"""What the test of a controller's package knows of the robot that it plays."""

from __future__ import annotations

from typing import Any

from robosc.emit.package.package import Mode
from robosc.expr.tree import ReasonRef
from robosc.language.events import EventKind
from robosc.model.entities import Communication, Robot
from robosc.plant.event_values import values_read

USUAL = {
    "event_log": "",
    "exit_on_stop": False,
    "on_mismatch": "ignore",
    "order": "rotate",
    "server_lost_after": 1e5,
    "state_rate": 200.0,
    "stop_command": "",
    "whole_values": True,
}
"""The parameters of a node under test, but for those of the model and those that a script sets."""

OF_MODE: dict[Mode, dict[str, Any]] = {
    "controller": {},
    "supervisor": {},
    "monitor": {"tolerance": 0.0},
}
"""Those of one mode: what is sent one by one does not cross."""
TOLD: dict[Mode, list[str]] = {
    "controller": [],
    "supervisor": ["~/blocked"],
    "monitor": ["~/findings"],
}
"""The topics on which a node tells what it judges."""

_FIELDS = {
    EventKind.RESPONSE: "response_field",
    EventKind.ERROR: "response_field",
    EventKind.FEEDBACK: "feedback_field",
    EventKind.REQUEST: "request_field",
    EventKind.CALL: "request_field",
    EventKind.ANSWER: "response_field",
    EventKind.PROGRESS: "feedback_field",
}
"""The field of a value that is no object, by the event that brings it."""


def communications_under_test(robot: Robot) -> dict[str, dict[str, Any]]:
    """By name: the key of a communication, its kind, and by event the field of a plain value."""
    return {
        robot.display_names[c.key]: {"key": c.key, "kind": c.kind.value, "fields": _fields(c)}
        for c in robot.communications.values()
    }


def read_when_failed(robot: Robot) -> list[str]:
    """The keys of the actions of which the model reads the result of a goal that failed."""
    found = []
    for transition in (t for component in robot.components for t in component.transitions):
        exprs = [a.value for a in transition.assignments]
        exprs += [] if transition.guard is None else [transition.guard]
        read = values_read(exprs).values()
        if transition.event is EventKind.ERROR and not all(isinstance(v, ReasonRef) for v in read):
            found.append(transition.communication)
    return sorted(set(found))


def _fields(communication: Communication) -> dict[str, str]:
    found = {}
    for sort in communication.sort.events:
        field = getattr(communication.binding, _FIELDS.get(sort.kind, ""), None)
        if field is not None:
            found[sort.kind.word] = field
    return found


def commands_under_test(robot: Robot) -> list[tuple[str, str]]:
    """Name and kind of each command."""
    return [
        (robot.display_names[c.key], sort.kind.word)
        for c in robot.communications.values()
        for sort in c.sort.events
        if sort.kind.controllable
    ]
