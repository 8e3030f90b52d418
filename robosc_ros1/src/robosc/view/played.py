"""The model itself as a source: whoever looks plays the robot.

The machine is one of ``robosc simulate``: single events of the supervised system, or the controller
as it executes, whose clock then follows the one on the wall.
"""

from __future__ import annotations

import random
import threading
import time
from collections.abc import Iterable
from typing import Any

from robosc import limits
from robosc.emit.package.model_document import model_document
from robosc.plant.automaton import Event
from robosc.runtime.core.telemetry import dump
from robosc.simulate.faults import LineFault
from robosc.simulate.machines.machine import (
    CommandState,
    Happening,
    Machine,
    event_of_document,
    label,
)
from robosc.simulate.script import documents
from robosc.simulate.values.event_data import complete
from robosc.simulate.values.literals import parse_raw
from robosc.view import server, tally
from robosc.view.hub import Hub

_TICK = 0.05

Json = dict[str, Any]


class Played:
    """A machine that is played by all browsers together."""

    def __init__(self, machine: Machine, hub: Hub) -> None:
        self._machine = machine
        self._hub = hub
        self._lock = threading.Lock()
        self._random = random.Random()
        self._number = 0
        self._begin(machine.beginning)
        supervisor = machine.supervisor
        source = machine.plant.robot.span.source.file_name
        hub.put("model", dump(model_document(supervisor, source)))
        hub.put("hello", dump({"source": "model", "title": source, "clock": self._has_clock}))

    @property
    def answers(self) -> server.Answers:
        return {"/do": self.do}

    @property
    def _has_clock(self) -> bool:
        return self._machine.time is not None

    def start(self) -> None:
        """Let the clock go, if there is one."""
        if self._has_clock:
            threading.Thread(target=self._run, name="clock", daemon=True).start()

    def do(self, document: Any) -> Json:
        """``{"event": {…}}`` with a ``value``, or a ``text`` as it is typed; ``{"undo": 1}``,
        ``{"restart": true}``, ``{"random": 10}``. Raises Unable."""
        with self._lock:
            try:
                match document:
                    case {"event": {"kind": str(), "name": str()} as event, **more}:
                        text = more.get("text")
                        raw = parse_raw(text) if isinstance(text, str) else event.get("value")
                        self._fire(event_of_document(self._machine, event), raw)
                    case {"random": int(count)} if 0 < count <= limits.RANDOM_WALK:
                        self._walk(count)
                    case {"undo": int(count)} if 0 < count <= self._undoable:
                        self._machine.undo(count)
                        self._undoable -= count
                    case {"undo": int()}:
                        raise server.Unable("there is nothing to undo")
                    case {"restart": _}:
                        self._machine.restart()
                        self._begin(self._machine.beginning)
                    case _:
                        raise server.Unable("there is no such request")
            except LineFault as fault:
                raise server.Unable(str(fault)) from None
            self._show()
        return {}

    def _begin(self, happenings: Iterable[Happening]) -> None:
        self._tally = tally.Tally(self._machine.plant.robot)
        self._undoable = 0
        self._number = 0
        self._epoch = time.time()
        self._hub.clear()
        self._tell(happenings)
        self._show()

    def _fire(self, event: Event, raw: Any) -> None:
        if event.kind.of_component:
            raw = None
        given = complete(self._machine.plant.robot, event, raw, label(event))
        self._tell(self._machine.fire(event, given))
        self._undoable += not self._has_clock

    def _walk(self, count: int) -> None:
        for _ in range(count):
            step = self._machine.draw(self._random)
            if step is None:
                raise server.Unable("nothing can happen any more")
            if isinstance(step, float):
                continue  # the clock goes by itself
            self._tell(self._machine.fire(*step))
            self._undoable += not self._has_clock

    def _run(self) -> None:
        """Turn the machine's clock on as time passes."""
        while True:
            time.sleep(_TICK)
            with self._lock:
                behind = time.time() - self._epoch - (self._machine.time or 0.0)
                if behind > 1.0:  # this machine slept, or its clock was set
                    self._epoch += behind - _TICK
                    behind = _TICK
                if behind <= 0.0:
                    continue
                happenings = self._machine.wait(behind)
                if happenings:
                    self._tell(happenings)
                    self._show()

    # --- what the page is sent -------------------------------------------------------------------

    def _tell(self, happenings: Iterable[Happening]) -> None:
        texts = []
        for happening in happenings:
            self._number += 1
            self._tally.take(happening.kind, happening.name, happening.outcome)
            at = time.time() if happening.time is None else self._epoch + happening.time
            document = {
                "version": 1,
                "number": self._number,
                **happening.document(),
                "time": round(at, 6),
            }
            texts.append(dump(document))
        self._hub.add(texts)

    def _show(self) -> None:
        machine = self._machine
        robot = machine.plant.robot
        commands = [c for c in machine.commands() if not c.event.kind.of_component]
        document = {
            **documents.state_document(machine),
            "version": 1,
            "robot": robot.name,
            "begun": None,  # the hub tells when another play begins
            "time": round(time.time(), 6),
            "number": self._number,
            "commands": [self._command(command) for command in commands],
            "clocks": {},  # time does not pass by itself
            "stopped": machine.stopped,
            "faults": [],
            "unconnected": [],
            "parameters": {p.name: p.default for p in robot.parameters},
            "counters": self._tally.counters,
            "latest": [],
            "choices": [
                {**documents.choice_document(choice), "short": choice.short or choice.text}
                for choice in machine.choices()
            ],
            "undo": self._undoable,
        }
        self._hub.put("state", dump(document))

    def _command(self, command: CommandState) -> Json:
        document = documents.command_document(command)
        event = command.event
        return {
            "count": self._tally.counts[event.name, event.kind.word],
            **document,
            "event": {**document["event"], "value": None},
        }
