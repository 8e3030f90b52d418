"""What the node tells the world: ``~state``, ``~model``, ``~events``, diagnostics, the event log.

The reporter has its own thread, so that nobody who reads slowly holds up the engine. It asks the
engine for a snapshot between two events, and makes the documents from that. Their schemas are in
robosc's ``docs/``; each has ``"version": 1``.
"""

from __future__ import annotations

import json
import threading
import time
from collections import deque
from typing import Any, Deque, Dict, List, Optional, Tuple

from .engine import Engine
from .eventlog import EventLog
from .journal import Entry
from .model import Command, Controller
from .values import jsonable

__all__ = ["Outlet", "Reporter", "blocked_by", "dump", "event_document", "state_document"]

OK, WARN, ERROR = 0, 1, 2  # the levels of diagnostic_msgs/DiagnosticStatus, REP 107
_LATEST = 10


class Outlet:
    """Where documents go; ``node.py`` implements it. Only the reporter's thread calls it."""

    def state(self, text: str) -> None:
        raise NotImplementedError

    def events(self, texts: List[str]) -> None:
        raise NotImplementedError

    def wants_events(self) -> bool:
        """Whether anybody listens to events."""
        return True

    def diagnostics(self, level: int, message: str, values: List[Tuple[str, str]]) -> None:
        raise NotImplementedError

    def legacy(self, text: str) -> None:
        """The state in the layout of the original tool, if that was asked for."""


def dump(document: Any) -> str:
    return json.dumps(jsonable(document), separators=(",", ":"), ensure_ascii=False)


def event_document(entry: Entry) -> Dict[str, Any]:
    """One event, spelled as everywhere in robosc's JSON, and what became of it."""
    event: Dict[str, Any] = {"kind": entry.kind, "name": entry.name}
    if entry.kind == "tau":
        event["index"] = entry.tau
    event["value"] = entry.value
    return {
        "version": 1,
        "number": entry.number,
        "time": round(entry.time, 6),
        "event": event,
        "outcome": entry.outcome,
        "detail": entry.detail,
    }


def blocked_by(controller: Controller, command: Command) -> List[Dict[str, str]]:
    """Why a command is not enabled now; empty if it is.

    Each reason has a ``kind``: "phase", "consent", "requirement" (with its ``place`` in the model),
    or "synthesis" where the requirements alone would allow it.
    """
    reasons = []
    if command.busy is not None and getattr(controller, command.busy) is (command.kind != "cancel"):
        word = "busy" if command.kind == "request" else "idle"
        reasons.append({"kind": "phase", "text": "it is " + word})
    if command.consent is not None and not getattr(controller, command.consent)():
        reasons.append({"kind": "consent", "text": "a component does not accept it in its state"})
    if getattr(controller, command.guard)():
        return reasons
    if command.kind == "cancel":
        reasons.append({"kind": "requirement", "text": "no requirement on it is violated"})
        return reasons
    failed = [
        {"kind": "requirement", "text": requirement.text, "place": requirement.place}
        for requirement in (controller.REQUIREMENTS[i] for i in command.requirements)
        if not getattr(controller, requirement.holds)()
    ]
    if not failed:
        text = command.reason or "it could lead to where the requirements cannot be kept"
        failed.append({"kind": "synthesis", "text": text})
    return reasons + failed


def state_document(snapshot: Dict[str, Any], latest: List[Dict[str, Any]]) -> Dict[str, Any]:
    """The document of ``~state``."""
    controller: Controller = snapshot["controller"]
    names = {c.key: c.name for c in controller.COMMUNICATIONS}
    phases = {}
    commands = []
    for command in controller.COMMANDS:
        if command.busy is not None:
            phases[names[command.key]] = "busy" if getattr(controller, command.busy) else "idle"
        reasons = blocked_by(controller, command)
        commands.append(
            {
                "event": {"kind": command.kind, "name": names[command.key], "value": None},
                "enabled": not reasons,
                "blocked_by": reasons,
                "count": snapshot["counts"][command.key, command.kind],
            }
        )
    return {
        "version": 1,
        "robot": controller.ROBOT,
        "time": round(time.time(), 6),
        "number": snapshot["number"],
        "components": controller.components(),
        "variables": controller.variables(),
        "communications": phases,
        "commands": commands,
        "stopped": snapshot["stopped"],
        "counters": snapshot["counters"],
        "latest": latest,
    }


def _legacy_document(document: Dict[str, Any], latest: List[Dict[str, Any]]) -> Dict[str, Any]:
    """States and variables per component, and the latest transitions by name."""
    variables: Dict[str, Dict[str, Any]] = {}
    for key, value in document["variables"].items():
        component, _, name = key.partition(".")
        variables.setdefault(component, {})[name] = value
    taken = ["%(kind)s_%(name)s" % entry["event"] for entry in latest]
    return {"states": document["components"], "variables": variables, "transitions": taken}


class Reporter:
    """Publishes while the engine runs. ``close`` publishes the last state and ends the thread."""

    def __init__(self, engine: Engine, outlet: Outlet) -> None:
        self._engine = engine
        self._outlet = outlet
        self._latest: Deque[Dict[str, Any]] = deque(maxlen=_LATEST)
        self._closing = threading.Event()
        settings = engine.settings
        self._pause = 1.0 / settings.state_rate
        self._log = None
        self._log_fault: Optional[str] = None
        if settings.event_log:
            self._log = EventLog(
                settings.event_log, int(settings.event_log_size * 1e6), settings.event_log_files
            )
        self._last_counters: Dict[str, int] = {}
        self._thread = threading.Thread(target=self._run, name="reporter", daemon=True)

    def start(self) -> None:
        self._thread.start()

    def close(self, timeout: float = 0.5) -> None:
        self._closing.set()
        self._engine.changed.set()
        self._thread.join(timeout)

    def _run(self) -> None:
        steady = time.monotonic
        next_diagnostics = steady()
        while True:
            self._engine.changed.wait(max(0.0, next_diagnostics - steady()))
            self._engine.changed.clear()
            closing = self._closing.is_set()
            periodic = closing or steady() >= next_diagnostics
            if periodic:
                next_diagnostics = steady() + 1.0
            self._report(periodic)
            if closing:
                return
            self._closing.wait(self._pause)

    def _report(self, periodic: bool) -> None:
        try:
            snapshot = self._snapshot()
            self._events()
            if snapshot is None:
                self._outlet.diagnostics(ERROR, "the engine does not answer", [])
                return
            latest = list(self._latest)
            document = state_document(snapshot, latest)
            self._outlet.state(dump(document))
            if self._engine.settings.legacy_state_topic:
                self._outlet.legacy(dump(_legacy_document(document, latest)))
            if periodic:
                self._outlet.diagnostics(*self._diagnosis(snapshot))
        except Exception as error:  # a report that fails must not end all others
            self._log_fault = "%s: %s" % (type(error).__name__, error)

    def _snapshot(self) -> Optional[Dict[str, Any]]:
        box: List[Dict[str, Any]] = []
        ready = threading.Event()

        def fill() -> None:
            box.append(self._engine.snapshot())
            ready.set()

        self._engine.invoke(fill)
        # At shutdown the engine's thread may be gone; nothing changes then any more.
        ready.wait(0.2 if self._closing.is_set() else 1.0)
        return box[0] if box else (self._engine.snapshot() if self._closing.is_set() else None)

    def _events(self) -> None:
        entries = self._engine.journal.take()
        if not entries:
            return
        publish = self._engine.settings.publish_events and self._outlet.wants_events()
        if not publish and self._log is None:
            self._latest.extend(event_document(entry) for entry in entries[-_LATEST:])
            return
        documents = [event_document(entry) for entry in entries]
        self._latest.extend(documents[-_LATEST:])
        lines = [dump(document) for document in documents]
        if publish:
            self._outlet.events(lines)
        if self._log is not None:
            try:
                self._log.write(lines)
                self._log_fault = None
            except OSError as error:
                self._log_fault = "event log: %s" % error

    def _diagnosis(self, snapshot: Dict[str, Any]) -> Tuple[int, str, List[Tuple[str, str]]]:
        counters: Dict[str, int] = snapshot["counters"]
        news = [
            "%d new %s" % (counters[name] - self._last_counters.get(name, 0), name)
            for name in ("mismatches", "errors", "failed", "undefined")
            if counters[name] > self._last_counters.get(name, 0)
        ]
        self._last_counters = dict(counters)
        if self._log_fault:
            news.append(self._log_fault)
        controller: Controller = snapshot["controller"]
        values = [(name, str(value)) for name, value in counters.items()]
        values.append(("backlog", str(snapshot["backlog"])))
        values.extend(controller.components().items())
        values.extend((k, str(v)) for k, v in controller.variables().items())
        if snapshot["stopped"] is not None:
            return ERROR, "safe stop: " + snapshot["stopped"], values
        return (WARN, ", ".join(news), values) if news else (OK, "running", values)
