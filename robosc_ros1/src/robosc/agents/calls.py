"""What becomes of a call, as an agent is told, and the way to a robot that calls take.

The outcome of a call is a JSON document, the same for a simulated and for a real robot: its
``outcome`` is "sent", "corrected", "blocked", "refused", "answered", "failed", "cancelled" or
"unknown". Beside it stand ``why`` as text, ``blocked_by`` and ``corrected`` as docs/schemas has
them, ``answer``, the data of the robot.
"""

from __future__ import annotations

import threading
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import replace
from typing import Any

from robosc.agents.tools import WHOLE, Tool
from robosc.expr.types import NoneType
from robosc.language.events import EventKind
from robosc.plant.event_values import value_type
from robosc.runtime.core.reasons import reason_text
from robosc.simulate import faults
from robosc.simulate.machines import execute, machine
from robosc.simulate.script.documents import command_document, state_document
from robosc.simulate.script.session import MakeMachine, Session
from robosc.simulate.values.literals import by_path

Json = Any

REACHED = ("sent", "corrected", "answered", "cancelled")
"""The outcomes after which the robot has got what was asked for."""


def unsent(word: str, why: str, **more: Json) -> Json:
    """A call of which nothing reached the robot, or of which nobody knows whether it did."""
    return {"outcome": word, "why": [why], **more}


def outcome_of(told: Mapping[str, Json]) -> Json:
    """What a command comes to, of which a supervisor tells this (event and blocked.schema.json)."""
    corrected = {"corrected": told["corrected"]} if told.get("corrected") else {}
    if found := told.get("blocked_by"):
        why = [reason_text(reason) for reason in found]
        return {"outcome": "blocked", "why": why, "blocked_by": found, **corrected}
    if told["outcome"] in ("refused", "failed"):
        return unsent(told["outcome"], str(told.get("detail") or "it was not passed on"))
    return {"outcome": "corrected" if corrected else "sent", **corrected}


class CallWatch:
    """How a call in another thread reports progress, and learns that nobody waits for it any more:
    it was cancelled, or its client has ``given_up``."""

    def __init__(
        self,
        report: Callable[[Json], None] = lambda what: None,
        given_up: Callable[[], bool] = lambda: False,
    ) -> None:
        self.report = report
        self._given_up = given_up
        self._cancelled = threading.Event()

    @property
    def cancelled(self) -> bool:
        return self._cancelled.is_set() or self._given_up()

    def cancel(self) -> None:
        self._cancelled.set()


class Gateway:
    """The way to a robot: a simulator, or a running node. All methods may be called from any
    thread, and may raise LineFault."""

    def __init__(self, make: MakeMachine) -> None:
        self._make = make

    def state(self) -> Json:
        """The state as ``~state`` has it."""
        raise NotImplementedError

    def events(self) -> Sequence[Json]:
        """The last events, oldest first."""
        raise NotImplementedError

    def ask(self, tool: Tool, arguments: Mapping[str, Any], watch: CallWatch) -> Json:
        """Do what a tool is for."""
        raise NotImplementedError

    def cancel(self, tool: Tool) -> Json:
        raise NotImplementedError

    def close(self) -> None:
        """End what was begun here."""

    def why(self, tool: Tool) -> str:
        """Why a command is allowed or not, its guard, and its requirements."""
        state = self.state()
        events = ((command["event"], command["blocked_by"]) for command in state["commands"])
        told = {(event["name"], event["kind"]): reasons for event, reasons in events}
        session, _ = self._copy(state)
        found = [
            replace(command, reasons=tuple(machine.Reason(**reason) for reason in told[name]))
            for command in session.machine.commands()
            if command.event.key == tool.key
            and (name := (command.event.name, command.event.kind.word)) in told
        ]
        if not found:
            raise faults.InvalidLine(f"{tool.name} is taken or refused when it is called")
        return session.about(found)

    def what_if(self, calls: Iterable[tuple[Tool, Mapping[str, Any]]]) -> Json:
        """What would become of calls, one after the other, from the current state; nothing is
        sent. The clocks of the model begin anew."""
        session, unknown = self._copy(self.state())
        found: Json = {
            "results": [{"call": tool.name, **fire(session, tool, given)} for tool, given in calls],
            "state_then": whole_state(session),
        }
        return {**found, "not_known": unknown} if unknown else found

    def _copy(self, state: Json) -> tuple[Session, Sequence[str]]:
        """A robot to try things with, in this state, and the variables of which it has not all."""
        session = Session(self._make, state.get("parameters", {}))
        assert isinstance(session.machine, execute.Execution)
        return session, session.machine.restore(state)


def whole_state(session: Session) -> Json:
    """The state of a simulated robot, with its commands, as ``~state`` has them."""
    commands = [c for c in session.machine.commands() if not c.event.kind.of_component]
    return {
        **state_document(session.machine),
        "commands": [command_document(command) for command in commands],
    }


def fire(
    session: Session, tool: Tool, arguments: Mapping[str, Any], *, cancels: bool = False
) -> Json:
    """Do in a simulator what a tool is for. What the robot answers is for who plays it."""
    data = dict(tool.data if tool.data is not None else arguments)
    plant = session.machine.plant
    kinds = (EventKind.CANCEL, EventKind.RECALL) if cancels else (EventKind.REQUEST, EventKind.CALL)
    try:
        event = next((e for e in plant.events if e.key == tool.key and e.kind in kinds), None)
        if event is None:
            raise faults.Refused(f"{tool.title} cannot be cancelled")
        # What the model does not read has no place in the simulator.
        is_read = data and not isinstance(value_type(plant.robot, event), NoneType)
        raw = data[WHOLE] if set(data) == {WHOLE} else by_path(data)
        done = session.fire(event, raw if is_read else None)
    except faults.LineFault as fault:
        return unsent("refused", str(fault))
    told = [_told(h) for h in done.happenings if h.name == event.name]
    for document in told:
        its_own = document["event"]["kind"] == event.kind.word
        if document["outcome"] in ("blocked", "refused") or (
            document["outcome"] == "applied" and its_own
        ):
            return outcome_of(document)
    if cancels:  # the model may not tell of it
        return {"outcome": "sent"}
    return unsent("unknown", "the model tells nothing of it")


def _told(happening: machine.Happening) -> Json:
    return {**happening.document(), **(happening.judged or {})}
