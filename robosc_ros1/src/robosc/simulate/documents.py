"""A session as JSON, version 1: what each line did, and what there is now (docs/simulate.md)."""

from __future__ import annotations

import json
from typing import Any

from robosc.model.entities import EventKind
from robosc.runtime.telemetry import dump
from robosc.simulate.event_data import given_json
from robosc.simulate.faults import InvalidLine, LineFault
from robosc.simulate.machine import CommandState, Machine, exact_event
from robosc.simulate.session import Done, Session
from robosc.synthesis.documents import event_document

__all__ = ["do_document", "done_document", "dump", "fault_document"]

Document = dict[str, Any]


def do_document(session: Session, text: str) -> tuple[Done, Any]:
    """Do what one document asks for; with its ``id``, which the answer carries, too.

    ``{"line": "distance free"}``, ``{"event": {"kind": …, "name": …, "value": …}}``, or a line of
    the script language as a string.

    Raises:
        LineFault: it was not done.
    """
    try:
        document = json.loads(text)
    except (ValueError, RecursionError) as error:
        raise InvalidLine(f"this is not JSON: {error}") from None
    if isinstance(document, str):
        document = {"line": document}
    if not isinstance(document, dict):
        raise InvalidLine('a document is {"line": …} or {"event": …}')
    identity = document.get("id")
    try:
        match document:
            case {"line": str(line)}:
                return session.do(line), identity
            case {"event": {"kind": str(kind), "name": str(name)} as event}:
                return _fire(session, kind, name, event), identity
        raise InvalidLine('a document is {"line": …} or {"event": {"kind": …, "name": …}}')
    except LineFault as fault:
        fault.args = (*fault.args, identity)
        raise


def _fire(session: Session, kind: str, name: str, event: Document) -> Done:
    value = event.get("value")
    if kind in (EventKind.TAU.value, EventKind.AFTER.value):
        kind, value = f"{kind}{event.get('index', 1)}", None
    return session.fire(exact_event(session.machine, f"{name}.{kind}"), value)


def done_document(session: Session, number: int, done: Done, identity: Any = None) -> Document:
    """The answer to a line that was done; line 0 is the beginning."""
    machine = session.machine
    document: Document = {"version": 1, "line": number, "ok": True}
    if identity is not None:
        document["id"] = identity
    if done.text:
        document["text"] = done.text
    document["happened"] = [h.document() for h in done.happenings]
    document["state"] = _state(machine)
    document["choices"] = [
        {
            "event": {**event_document(choice.event), "value": given_json(choice.given or {})},
            "text": choice.text,
            "controllable": choice.event.controllable,
            "needs": choice.hint or None,
        }
        for choice in session.menu()
    ]
    document["commands"] = [_command(command) for command in machine.commands()]
    return document


def fault_document(number: int, fault: LineFault) -> Document:
    """The answer to a line that was not done: ``wrong``, ``refused`` or ``failed``, and why."""
    document: Document = {"version": 1, "line": number, "ok": False}
    if len(fault.args) > 1 and fault.args[1] is not None:
        document["id"] = fault.args[1]
    return {**document, "fault": fault.kind, "message": str(fault.args[0])}


def _state(machine: Machine) -> Document:
    state = machine.state
    names = machine.plant.robot.display_names
    document: Document = {
        "components": dict(state.components),
        "variables": dict(state.variables),
        "communications": {names[key]: phase for key, phase in state.phases.items()},
        "marked": state.marked(machine.plant.robot),
    }
    if machine.time is not None:
        document |= {"time": round(machine.time, 6), "stopped": machine.stopped}
    return document


def _command(command: CommandState) -> Document:
    document: Document = {
        "event": event_document(command.event),
        "enabled": command.enabled,
        "blocked_by": [
            {"kind": r.kind, "text": r.text} | ({"place": r.place} if r.place else {})
            for r in command.reasons
        ],
        "data": command.data,
    }
    if command.count is not None:
        document["count"] = command.count
    return document
