"""A run of a generated node against the model: does its event log stay within it?

The log is read into a controller that is generated from the model: what the robot sent is applied,
and each command must have been allowed then, with just the data that the model provides.
"""

from __future__ import annotations

import json
import re
from collections.abc import Iterator
from copy import copy
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from robosc.errors import UsageError
from robosc.runtime.model import Command, Controller, Input, Tau
from robosc.runtime.report import blocked_by
from robosc.runtime.values import Mismatch, jsonable
from robosc.simulate.generated import make_controller
from robosc.supervisor import Supervisor

__all__ = [
    "Departure", "Entry", "Follower", "Replayed", "read_log", "replay", "replay_document",
    "replay_text",
]  # fmt: skip

_KINDS = ("request", "response", "feedback", "error", "cancel", "tau", "stop")
_OUTCOMES = ("applied", "mismatch", "failed", "stopped")


@dataclass(frozen=True)
class Departure:
    """Where a run leaves the model; ``number`` is the event's in the log."""

    file: str
    line: int
    number: int
    event: str
    reason: str


@dataclass(frozen=True)
class Replayed:
    """What a log holds. ``missing`` tells of events that the log lost, so that the rest of that run
    could not be followed."""

    robot: str
    runs: int
    events: int
    mismatches: int
    departures: tuple[Departure, ...]
    missing: tuple[str, ...]

    @property
    def exit_code(self) -> int:
        """1: a run leaves the model; 2: it could not be followed to its end."""
        return 1 if self.departures else 2 if self.missing else 0


@dataclass(frozen=True)
class Entry:
    """A line of a log; ``document`` is all of it."""

    document: dict[str, Any]
    file: str
    line: int
    number: int
    kind: str
    name: str
    index: int
    value: Any
    outcome: str

    @property
    def text(self) -> str:
        name = f"{self.name}.{self.kind}" if self.name else self.kind
        return f"{name}{self.index}" if self.kind == "tau" else name


def replay(supervisor: Supervisor, log: str, stop_command: str | None = None) -> Replayed:
    """Follow all runs of a log. Older files of a rotated log (``LOG.1`` …) are read before it.

    ``stop_command`` is the node's parameter of that name: such a command may be sent at a stop,
    guard or not.

    Raises:
        UsageError: a file cannot be read, or is no event log.
    """
    follower = Follower(supervisor, stop_command)
    for entry in read_log(log):
        follower.take(entry)
    if not follower.runs:
        raise UsageError(f"{log} holds no events")
    return Replayed(
        supervisor.plant.robot.name,
        follower.runs,
        follower.events,
        follower.mismatches,
        tuple(follower.departures),
        tuple(follower.missing),
    )


class Follower:
    """Follows one run after the other; each begins with event 1."""

    def __init__(self, supervisor: Supervisor, stop_command: str | None) -> None:
        self._fresh = make_controller(supervisor)
        names = {c.key: c.name for c in self._fresh.COMMUNICATIONS}
        self._inputs = {(names[i.key], i.kind): i for i in self._fresh.INPUTS}
        self._commands = {(names[c.key], c.kind): c for c in self._fresh.COMMANDS}
        self._taus = {(t.component, t.number): t for t in self._fresh.TAUS}
        if stop_command is not None and (stop_command, "request") not in self._commands:
            raise UsageError(f"{stop_command} is no command of {self._fresh.ROBOT}")
        self._stop_command = stop_command
        self._controller: Controller | None = None
        self._next = 1
        self.runs = self.events = self.mismatches = 0
        self.departures: list[Departure] = []
        self.missing: list[str] = []

    @property
    def controller(self) -> Controller | None:
        """In the state after the last event; None where that is not known (any more)."""
        return self._controller

    def fork(self) -> Follower:
        """Another one that goes on from here by itself."""
        other = copy(self)
        other._controller = None if self._controller is None else self._controller.copy()
        other.departures = list(self.departures)
        other.missing = list(self.missing)
        return other

    def take(self, entry: Entry) -> None:
        self.events += 1
        self.mismatches += entry.outcome == "mismatch"
        if entry.number == 1 or not self.runs:
            self.runs += 1
            self._controller = self._fresh.copy()
            self._next = 1
        if self._controller is None:
            return
        if entry.number != self._next:
            place = f"{entry.file}:{entry.line}"
            self.missing.append(f"{place}: events {self._next} to {entry.number - 1} are missing")
            self._controller = None
            return
        self._next += 1
        if entry.outcome != "applied":
            return
        reason = self._leaves(self._controller, entry)
        if reason is not None:
            departure = Departure(entry.file, entry.line, entry.number, entry.text, reason)
            self.departures.append(departure)
            self._controller = None  # what follows is not known any more

    def _leaves(self, controller: Controller, entry: Entry) -> str | None:
        """Apply an event; why it cannot be, if so."""
        if entry.kind == "tau":
            tau = self._taus.get((entry.name, entry.index))
            return _step(controller, tau, entry.value)
        owed = next((t for t in controller.TAUS if _can_step(controller, t)), None)
        if owed is not None:
            return f"{owed.component} had to take its own step {owed.number} before"
        input_ = self._inputs.get((entry.name, entry.kind))
        if input_ is not None:
            return _apply(controller, input_, entry.value)
        command = self._commands.get((entry.name, entry.kind))
        if command is not None:
            stopping = entry.name == self._stop_command and entry.kind == "request"
            return _perform(controller, command, entry.value, stopping)
        return f"the model has no {entry.text}"


def _can_step(controller: Controller, tau: Tau) -> bool:
    return getattr(controller.copy(), tau.step)() is not None


def _step(controller: Controller, tau: Tau | None, path: Any) -> str | None:
    if tau is None:
        return "the model has no such step"
    taken = getattr(controller, tau.step)()
    return None if taken == path else f"the model goes {taken or 'nowhere'} here, not {path}"


def _apply(controller: Controller, input_: Input, value: Any) -> str | None:
    try:
        getattr(controller, input_.apply)(_restored(value))
    except Mismatch as mismatch:
        return str(mismatch)
    except (AttributeError, TypeError, ValueError, LookupError) as error:
        return f"its value {json.dumps(value)} is not what the model carries ({error})"
    return None


def _perform(controller: Controller, command: Command, value: Any, stopping: bool) -> str | None:
    reasons = blocked_by(controller, command)
    if reasons and not stopping:
        return "; ".join(f"{r['text']} ({r['place']})" if "place" in r else r["text"]
                         for r in reasons)  # fmt: skip
    if command.data is not None:
        provided = json.loads(json.dumps(jsonable(getattr(controller, command.data)())))
        if provided != value:
            return f"the model sends {json.dumps(provided)}, the log has {json.dumps(value)}"
    if command.apply is not None and (not reasons or _consents(controller, command)):
        getattr(controller, command.apply)()
    return None


def _consents(controller: Controller, command: Command) -> bool:
    return command.consent is None or bool(getattr(controller, command.consent)())


_NUMBERS = {"NaN": float("nan"), "Infinity": float("inf"), "-Infinity": float("-inf")}


def _restored(value: Any) -> Any:
    """The numbers that JSON lacks."""
    if isinstance(value, dict):
        return {key: _restored(part) for key, part in value.items()}
    return _NUMBERS.get(value, value) if isinstance(value, str) else value


# --- reading -------------------------------------------------------------------------------------


def read_log(log: str) -> Iterator[Entry]:
    """All events of a log and its older parts, oldest first. Raises UsageError."""
    for path in _files(Path(log)):
        try:
            with path.open(encoding="utf-8") as file:
                for number, line in enumerate(file, 1):
                    if line.strip():
                        yield _entry(str(path), number, line)
        except UnicodeDecodeError as error:
            raise UsageError(f"{path} is no UTF-8 text") from error
        except (OSError, ValueError) as error:
            raise UsageError(f"cannot read {path}: {_reason(error)}") from error


def _reason(error: OSError | ValueError) -> str:
    return (error.strerror if isinstance(error, OSError) else None) or str(error)


def _files(log: Path) -> list[Path]:
    """The log after its older parts, oldest first."""
    pattern = re.compile(re.escape(log.name) + r"\.(\d+)")
    try:
        older = [
            (int(match[1]), path)
            for path in log.parent.iterdir()
            if (match := pattern.fullmatch(path.name))
        ]
    except OSError:
        older = []
    return [path for _, path in sorted(older, reverse=True)] + [log]


def _entry(file: str, line: int, text: str) -> Entry:
    try:
        document = json.loads(text)
    except (ValueError, RecursionError):
        document = None
    match document:
        case {
            "version": 1,
            "number": int(number),
            "event": {"kind": str(kind), "name": str(name)} as event,
            "outcome": str(outcome),
        } if kind in _KINDS and outcome in _OUTCOMES:
            index = event.get("index", 0)
            if isinstance(index, int):
                value = event.get("value")
                return Entry(document, file, line, number, kind, name, index, value, outcome)
    raise UsageError(f"{file}:{line}: this is no event of a log, version 1")


# --- results -------------------------------------------------------------------------------------


def replay_text(found: Replayed) -> str:
    lines = [
        f"{d.file}:{d.line}: event {d.number}, {d.event}, leaves the model: {d.reason}"
        for d in found.departures
    ]
    lines += found.missing
    runs = "1 run" if found.runs == 1 else f"{found.runs} runs"
    verdict = "leaves the model" if found.departures else "follows the model"
    if found.missing and not found.departures:
        verdict += " as far as the log is complete"
    reported = f", {found.mismatches} mismatches reported" if found.mismatches else ""
    lines.append(f"{found.robot}: {runs}, {found.events:,} events{reported}: {verdict}")
    return "\n".join(lines) + "\n"


def replay_document(found: Replayed) -> dict[str, Any]:
    """``replay --json``, version 1."""
    return {
        "version": 1,
        "robot": found.robot,
        "runs": found.runs,
        "events": found.events,
        "mismatches": found.mismatches,
        "departures": [
            {"file": d.file, "line": d.line, "number": d.number, "event": d.event,
             "reason": d.reason}
            for d in found.departures
        ],
        "missing": list(found.missing),
    }  # fmt: skip
