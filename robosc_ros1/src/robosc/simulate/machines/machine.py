"""What a session asks of a machine, and what a machine answers."""

from __future__ import annotations

import math
import random
import re
from collections.abc import Mapping, Sequence
from dataclasses import field, replace
from difflib import get_close_matches
from typing import Any, Protocol

from robosc import dotted, errors
from robosc.expr.tree import Expr
from robosc.language.events import EventKind
from robosc.lazy_dataclasses import dataclass
from robosc.model.entities import Robot
from robosc.plant import automaton, event_values, step
from robosc.runtime.core.reasons import reason_text
from robosc.runtime.core.telemetry import named
from robosc.simulate.faults import InvalidLine
from robosc.simulate.machines.state import SystemState
from robosc.simulate.values.event_data import Given, given_text
from robosc.supervisor import Supervisor

EVENT_NAME = r"(?:[\w.^]|\[-?\d+\])+"
"""A regular expression: how the name of an event is written."""
_EVENT_AND_VALUE = re.compile(rf"({EVENT_NAME})\s*(?:\((.*)\)|\s(.*))?", re.DOTALL | re.ASCII)

MANY = 12
"""An event with more values than this is offered once, its value to be typed."""


@dataclass(frozen=True)
class Choice:
    """Something that can be fired now. ``given`` None: its value is to be typed (see ``hint``).

    ``short`` is the text where it need not be typed, with ranges of numbers as people write them.
    """

    event: automaton.Event
    given: Given | None
    text: str
    hint: str = ""
    short: str = ""


@dataclass(frozen=True)
class Reason:
    """Why a command is not enabled.

    ``kind``: "phase", "synchronisation", "range", "requirement" or "synthesis".
    ``place`` is file and line of the requirement, ``because`` what of it does not hold.
    """

    kind: str
    text: str
    place: str | None = None
    because: Sequence[str] = ()

    def __str__(self) -> str:
        return reason_text(self.document())

    def document(self) -> dict[str, Any]:
        place = {"place": self.place} if self.place else {}
        because = {"because": list(self.because)} if self.because else {}
        return {"kind": self.kind, "text": self.text, **place, **because}


@dataclass(frozen=True)
class CommandState:
    """A controllable event now. ``data`` is what would be sent; ``count`` how often it was.

    ``waits_for`` are the enabled commands that a controller sends instead of it, as preferred ones.
    """

    event: automaton.Event
    reasons: tuple[Reason, ...]
    data: dict[str, Any] | None = None
    count: int | None = None
    waits_for: tuple[str, ...] = ()

    @property
    def enabled(self) -> bool:
        return not self.reasons


def with_preferences(
    commands: list[CommandState], robot: Robot, phases: Mapping[str, str]
) -> list[CommandState]:
    """Return the commands, each with those that it waits for. ``phases`` are those of the
    communications by key: what would replace a goal is waited for by none. A supervisor's commands
    wait for none: another controller chooses them."""
    if robot.supervises:
        return commands
    enabled = {
        command.event.command: named(command.event.kind.word, command.event.name)
        for command in commands
        if command.enabled
        and command.event.kind.sent
        and not _is_replacing(command.event, robot, phases)
    }

    def waits_for(event: automaton.Event) -> tuple[str, ...]:
        if not event.kind.sent or event.command not in enabled:
            return ()
        preferred = robot.yields_to.get(event.command, ())
        return tuple(name for key, name in enabled.items() if key in preferred)

    return [replace(command, waits_for=waits_for(command.event)) for command in commands]


def _is_replacing(event: automaton.Event, robot: Robot, phases: Mapping[str, str]) -> bool:
    """Whether a request would replace a goal."""
    return bool(robot.communications[event.key].goals) and phases[event.key] == "busy"


@dataclass(frozen=True)
class Happening:
    """One event that took place: as in the event log of a running controller.

    ``controllable``: the controller decided on it. ``time`` is that of the virtual clock, in
    seconds; None where there is none. ``judged`` is what a supervisor says of it: ``blocked_by``
    and ``corrected`` as docs/schemas has them. ``reason`` is what models call the reason of an
    error.
    """

    kind: str
    name: str
    value: Any = None
    index: int = 0
    outcome: str = "applied"
    detail: str | None = None
    time: float | None = None
    controllable: bool = False
    judged: Mapping[str, Any] | None = field(default=None, compare=False)
    reason: str | None = None

    @property
    def is_command(self) -> bool:
        """Whether the controller sent it."""
        return self.controllable and self.kind != EventKind.TAU.word

    def document(self) -> dict[str, Any]:
        event: dict[str, Any] = {"kind": self.kind, "name": self.name}
        if self.index:
            event["index"] = self.index
        event["value"] = self.value
        found: dict[str, Any] = {"event": event, "outcome": self.outcome, "detail": self.detail}
        if self.time is not None:
            found["time"] = round(self.time, 6)
        if self.reason is not None:
            found["reason"] = self.reason
        return found


class Machine(Protocol):
    """A robot that is played. Machines refuse with :class:`Refused`, and then nothing changed."""

    supervisor: Supervisor
    beginning: Sequence[Happening]
    """What happened before the first event."""

    @property
    def plant(self) -> automaton.Plant: ...

    @property
    def state(self) -> SystemState: ...

    @property
    def time(self) -> float | None:
        """Seconds on the virtual clock; None where time does not matter."""

    @property
    def stopped(self) -> str | None:
        """Why the controller made a safe stop, or None."""

    @property
    def typeable(self) -> Sequence[automaton.Event]:
        """The events that may be fired at all."""

    def choices(self) -> list[Choice]: ...

    def commands(self) -> list[CommandState]: ...

    def can(self, event: automaton.Event, given: Given | None) -> bool:
        """Whether it can happen now; without a value, whether any value of it can."""

    def fire(self, event: automaton.Event, given: Given) -> list[Happening]: ...

    def wait(self, seconds: float) -> list[Happening]: ...

    def path(self, condition: Expr) -> list[tuple[automaton.Event, Given]] | None:
        """The shortest way to where the condition holds; None if there is no such state."""

    def draw(self, rng: random.Random) -> tuple[automaton.Event, Given] | float | None:
        """What happens next at random: an event, seconds to wait, or None if nothing can."""

    def undo(self, count: int) -> None:
        """Take that many of the last ``fire`` and ``wait`` back; there are as many."""

    def restart(self) -> None: ...


def label(event: automaton.Event) -> str:
    """How an event is typed: ``grab.request``, ``Door.tau2``."""
    return _label(event, event.name)


def _label(event: automaton.Event, name: str) -> str:
    index = event.index if event.kind.of_component else ""
    return f"{name}.{event.kind.word}{index}"


def typed_text(event: automaton.Event, given: Given) -> str:
    """An event with its value, as it can be typed: ``distance.response(free)``."""
    text = given_text(given)
    return f"{label(event)}({text})" if text else label(event)


def event_and_value(text: str) -> tuple[str, str] | None:
    """The name and the value in ``distance.response(free)`` or ``distance free``.

    None if it does not begin with a name.
    """
    match = _EVENT_AND_VALUE.fullmatch(text)
    return None if match is None else (match[1], match[2] or match[3] or "")


def is_typed(robot: Robot, event: automaton.Event) -> bool:
    """Whether its value is to be typed: it has data that decide nothing, or too many values."""
    decided = {p.path for p in event.parameters}
    few = math.prod(len(p.values) for p in event.parameters) <= MANY
    return not few or bool(event_values.value_parts(robot, event).keys() - decided)


def draw_values(event: automaton.Event, rng: random.Random) -> tuple[Any, ...]:
    """One of the combinations that the parameters can have."""
    if math.prod(len(p.values) for p in event.parameters) <= 1000:
        return rng.choice(list(step.valuations(event)))
    return tuple(
        rng.choice([v for v in p.values if v is not None] if None in p.values else p.values)
        for p in event.parameters
    )


def without_timeouts(events: Sequence[automaton.Event]) -> list[automaton.Event]:
    """Those that a bare name means: a message, rather than that none came."""
    return [e for e in events if e.kind is not EventKind.TIMEOUT] or list(events)


def without_cases(events: Sequence[automaton.Event]) -> list[automaton.Event]:
    """One of the events for each request, whose cases differ in their data only."""
    return list({id(event.whole or event): event for event in events}.values())


def find_events(machine: Machine, text: str) -> list[automaton.Event]:
    """The events that a name can mean, best first. Raises InvalidLine if there is none.

    ``grab.request`` in full, ``grab`` for all events of it, or the beginning of either.
    """
    text = text.replace("^", "")
    events = machine.typeable
    for fits in (_is_label, _is_bare_name, _begins_label):
        found = [event for event in events if fits(event, text)]
        if found:
            return without_cases(found)
    raise InvalidLine(_unknown(machine, text))


def event_of_document(machine: Machine, document: Mapping[str, Any]) -> automaton.Event:
    """The event that a document names: ``kind``, ``name`` and, of a component, ``index``.

    Raises:
        InvalidLine: there is none.
    """
    kind = document["kind"]
    if kind in (EventKind.TAU.word, EventKind.AFTER.word):
        kind = f"{kind}{document.get('index', 1)}"
    text = f"{document['name']}.{kind}"
    for event in machine.typeable:
        if _is_label(event, text):
            return event
    raise InvalidLine(_unknown(machine, text))


def is_name(event: automaton.Event, text: str) -> bool:
    """Whether a text names the event: in full, or the communication or component alone."""
    return _is_label(event, text) or _is_bare_name(event, text)


def _is_label(event: automaton.Event, text: str) -> bool:
    return text in (label(event), _key_label(event))


def _is_bare_name(event: automaton.Event, text: str) -> bool:
    return text in (event.name, event.key)


def _begins_label(event: automaton.Event, text: str) -> bool:
    return _begins(label(event), text) or _begins(_key_label(event), text)


def _begins(whole: str, text: str) -> bool:
    """Whether a text begins a label, or each of its parts: ``gr.re`` for ``grab.request``."""
    parts, begun = dotted.parts(whole), dotted.parts(text)
    return whole.startswith(text) or (
        len(parts) == len(begun) and all(p.startswith(b) for p, b in zip(parts, begun, strict=True))
    )


def _unknown(machine: Machine, text: str) -> str:
    mine = set(map(id, machine.typeable))
    for event in machine.plant.events:
        if id(event) not in mine and text in (label(event), _key_label(event), event.name):
            return f"{label(event)} is sent by the controller itself: wait, or let something happen"
    labels = [label(e) for e in machine.typeable]
    near = get_close_matches(text, [*labels, *(e.name for e in machine.typeable)], 1)
    if near:
        return f"there is no event '{text}'; did you mean '{near[0]}'?"
    few = f"; there are {errors.listing(labels)}" if len(labels) <= 8 else ""
    return f"there is no event or command '{text}'{few} (see help)"


def _key_label(event: automaton.Event) -> str:
    return _label(event, event.key)
