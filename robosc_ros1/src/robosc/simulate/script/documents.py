"""A session as JSON, version 1: what each line did, and what there is now (docs/simulate.md)."""

from __future__ import annotations

import json
from typing import Any

from robosc.runtime.core.places import places, stages
from robosc.simulate.faults import InvalidLine, LineFault
from robosc.simulate.machines.machine import Choice, CommandState, Machine, event_of_document
from robosc.simulate.script.session import Done, Session
from robosc.simulate.values.event_data import given_json
from robosc.synthesis.documents import event_document

Document = dict[str, Any]


def answer(session: Session, number: int, text: str) -> tuple[Document, Done | LineFault]:
    """Do what one document asks for; return the answer to it, with its ``id``, and what it did.

    ``{"line": "distance free"}``, ``{"event": {"kind": …, "name": …, "value": …}}``, or a line of
    the script language as a string.
    """
    identity = None
    try:
        document = _read(text)
        identity = document.get("id")
        done = _do(session, document)
    except LineFault as fault:
        return fault_document(number, fault, identity), fault
    return done_document(session, number, done, identity), done


def _read(text: str) -> Document:
    try:
        document = json.loads(text)
    except (ValueError, RecursionError) as error:
        raise InvalidLine(f"this is not JSON: {error}") from None
    if isinstance(document, str):
        return {"line": document}
    if not isinstance(document, dict):
        raise InvalidLine('a document is {"line": …} or {"event": …}')
    return document


def _do(session: Session, document: Document) -> Done:
    match document:
        case {"line": str(line)}:
            return session.do(line)
        case {"event": {"kind": str(), "name": str()} as event}:
            found = event_of_document(session.machine, event)
            return session.fire(found, None if found.kind.of_component else event.get("value"))
    raise InvalidLine('a document is {"line": …} or {"event": {"kind": …, "name": …}}')


def done_document(session: Session, number: int, done: Done, identity: Any = None) -> Document:
    """The answer to a line that was done; line 0 is the beginning."""
    machine = session.machine
    document: Document = {"version": 1, "line": number, "ok": True}
    if identity is not None:
        document["id"] = identity
    if done.text:
        document["text"] = done.text
    document["happened"] = [h.document() for h in done.happenings]
    document["state"] = state_document(machine)
    document["choices"] = [choice_document(choice) for choice in session.menu()]
    document["commands"] = [command_document(command) for command in machine.commands()]
    return document


def fault_document(number: int, fault: LineFault, identity: Any = None) -> Document:
    """The answer to a line that was not done: ``wrong``, ``refused`` or ``failed``, and why."""
    document: Document = {"version": 1, "line": number, "ok": False}
    if identity is not None:
        document["id"] = identity
    return {**document, "fault": fault.kind, "message": str(fault)}


def choice_document(choice: Choice) -> Document:
    """Something that can happen now; ``needs`` is what may be written as its value."""
    return {
        "event": {**event_document(choice.event), "value": given_json(choice.given or {})},
        "text": choice.text,
        "controllable": choice.event.controllable,
        "needs": choice.hint or None,
    }


def state_document(machine: Machine) -> Document:
    """The state of the robot, and of the clock if there is one."""
    state = machine.state
    names = machine.plant.robot.display_names
    document: Document = {
        "components": places(state.components),
        "variables": {
            **state.variables,
            **stages(state.components, machine.plant.robot.stages),
        },
        "communications": {names[key]: phase for key, phase in state.phases.items()},
        "marked": state.marked(machine.plant.robot),
    }
    if machine.time is not None:
        document |= {"time": round(machine.time, 6), "stopped": machine.stopped}
    return document


def command_document(command: CommandState) -> Document:
    """Whether a command is enabled, else why not, and what it would send."""
    document: Document = {
        "event": event_document(command.event),
        "enabled": command.enabled,
        "blocked_by": [reason.document() for reason in command.reasons],
        "waits_for": list(command.waits_for),
        "data": command.data,
    }
    if command.count is not None:
        document["count"] = command.count
    return document
