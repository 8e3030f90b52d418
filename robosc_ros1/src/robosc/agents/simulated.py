"""Calls of an agent in the simulator: the generated code, and whoever plays the robot around it."""

from __future__ import annotations

import threading
from collections.abc import Iterable, Mapping, Sequence
from typing import Any

from robosc.agents.outcomes import CallOutcome, CallWatch, blocked, sent, unsent
from robosc.agents.tools import WHOLE, Tool
from robosc.expr.types import NoneType
from robosc.language.events import EventKind
from robosc.plant.automaton import Event
from robosc.plant.event_values import value_type
from robosc.runtime.reasons import reason_text
from robosc.simulate.faults import LineFault, Refused
from robosc.simulate.machines.execute import Execution
from robosc.simulate.machines.machine import Happening, label
from robosc.simulate.script.documents import command_document, state_document
from robosc.simulate.script.session import MakeMachine, Session
from robosc.simulate.values.event_data import complete
from robosc.simulate.values.literals import Raw

Json = Any


class Simulated:
    """A robot that is played by lines of ``robosc simulate``, and commanded by an agent.

    May be used from several threads.
    """

    def __init__(self, make: MakeMachine, parameters: Mapping[str, Any]) -> None:
        self._make = make
        self._parameters = dict(parameters)
        self._session = Session(make, parameters)
        self._lock = threading.Lock()
        self._latest: list[Json] = [h.document() for h in self._session.machine.beginning]

    def state(self) -> Json:
        with self._lock:
            return _state(self._session.machine)

    def events(self) -> Sequence[Json]:
        with self._lock:
            return list(self._latest)

    def held(self) -> str | None:
        """Why nothing can be sent at all, or None."""
        return self._session.machine.stopped

    def ask(self, tool: Tool, arguments: Mapping[str, Any], watch: CallWatch) -> CallOutcome:
        """Do what a tool is for. What the robot answers is for :meth:`play`."""
        with self._lock:
            outcome, happenings = _fire(self._session.machine, tool, arguments)
            self._note(happenings)
        return outcome

    def cancel(self, tool: Tool) -> CallOutcome:
        with self._lock:
            outcome, happenings = _fire(self._session.machine, tool, {}, cancels=True)
            self._note(happenings)
        return outcome if outcome.word != "unknown" else sent()  # the model may not tell of it

    def play(self, line: str) -> Json:
        """Do a line of the simulator: what the robot sends, or ``wait 2``.

        Raises:
            LineFault: it was not done.
        """
        with self._lock:
            done = self._session.do(line)
            self._note(done.happenings)
            happened = [h.document() for h in done.happenings]
        return {"text": done.text, "happened": happened}

    def why(self, name: str) -> str:
        with self._lock:
            return self._session.do(f"why {name}").text

    def what_if(self, calls: Iterable[tuple[Tool, Mapping[str, Any]]]) -> Json:
        return what_if(self._make, self._parameters, self.state(), calls)

    def close(self) -> None:
        """There is nothing to leave."""

    def _note(self, happenings: Iterable[Happening]) -> None:
        self._latest = [*self._latest, *(h.document() for h in happenings)][-50:]


def what_if(
    make: MakeMachine,
    parameters: Mapping[str, Any],
    state: Json,
    calls: Iterable[tuple[Tool, Mapping[str, Any]]],
) -> Json:
    """Return what would become of calls, one after the other, in a state; nothing is sent.

    ``state`` is a document of ``~state`` or of the simulator. The clocks of the model begin anew.
    """
    machine = make(parameters)
    assert isinstance(machine, Execution)
    unknown = machine.restore(state)
    results = []
    for tool, arguments in calls:
        outcome, _ = _fire(machine, tool, arguments)
        results.append({"call": tool.name, **outcome.document()})
    found: Json = {"results": results, "state_then": state_document(machine)}
    if unknown:
        found["not_known"] = unknown
    return found


def _state(machine: Any) -> Json:
    commands = [c for c in machine.commands() if not c.event.kind.of_component]
    return {**state_document(machine), "commands": [command_document(c) for c in commands]}


def _fire(
    machine: Any, tool: Tool, arguments: Mapping[str, Any], *, cancels: bool = False
) -> tuple[CallOutcome, list[Happening]]:
    robot = machine.plant.robot
    data = tool.data if tool.data is not None else arguments
    try:
        event = _event(machine, tool, cancels)
        # What the model does not read has no place in the simulator.
        read = not isinstance(value_type(robot, event), NoneType)
        given = complete(robot, event, _raw(data) if read and data else None, label(event))
        happenings = machine.fire(event, given)
    except LineFault as fault:
        return unsent("refused", str(fault)), []
    return _outcome(happenings, event), happenings


def _event(machine: Any, tool: Tool, cancels: bool) -> Event:
    kinds = (EventKind.CANCEL, EventKind.RECALL) if cancels else (EventKind.REQUEST, EventKind.CALL)
    found: list[Event] = [e for e in machine.plant.events if e.key == tool.key and e.kind in kinds]
    if not found:
        raise Refused(f"{tool.title} cannot be cancelled")
    return found[0]


def _raw(data: Mapping[str, Any]) -> Raw:
    """Arguments as the simulator takes a value: literals by path, or a single one."""
    if set(data) == {WHOLE} and not isinstance(data[WHOLE], Mapping):
        return data[WHOLE]
    found: dict[str, Any] = {}
    for name, value in data.items():
        if isinstance(value, Mapping):
            inner = _raw(value)
            assert isinstance(inner, dict)
            found |= {f"{name}.{path}": part for path, part in inner.items()}
        else:
            found[name] = value
    return found


def _outcome(happenings: Sequence[Happening], event: Event) -> CallOutcome:
    own = [h for h in happenings if h.name == event.name]
    for happening in own:
        judged = happening.judged or {}
        if happening.outcome == "blocked":
            return blocked(judged.get("blocked_by", ()), **_corrected(judged))
        if happening.outcome == "refused":
            return unsent("refused", happening.detail or "nothing takes it now")
        if happening.kind == event.kind.word and happening.outcome == "applied":
            return sent(judged.get("corrected"))
    return unsent("unknown", "the model tells nothing of it")


def _corrected(judged: Mapping[str, Json]) -> dict[str, Json]:
    return {"corrected": judged["corrected"]} if "corrected" in judged else {}


def reasons_of(state: Json, name: str) -> list[str]:
    """Return why a command is not enabled, from a document of the state; empty if it is."""
    for command in state.get("commands", ()):
        event = command["event"]
        if event["name"] == name and event["kind"] == "request":
            return [reason_text(reason) for reason in command["blocked_by"]]
    return []
