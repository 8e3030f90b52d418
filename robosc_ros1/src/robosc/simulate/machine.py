"""What a session asks of a machine, and what a machine answers."""

from __future__ import annotations

import math
import random
from collections.abc import Sequence
from dataclasses import dataclass, field
from difflib import get_close_matches
from typing import Any, Protocol

from robosc.errors import listing
from robosc.ir.automaton import Event, Plant
from robosc.ir.step import valuations
from robosc.model.entities import EventKind
from robosc.model.expr import Expr
from robosc.simulate.event_data import Given
from robosc.simulate.faults import InvalidLine
from robosc.simulate.state import SystemState
from robosc.supervisor import Supervisor

__all__ = [
    "Choice", "CommandState", "Happening", "Machine", "Reason", "brought", "draw_values",
    "exact_event", "few_values", "find_events", "label",
]  # fmt: skip

MANY = 12
"""An event with more values than this is offered once, its value to be typed."""


@dataclass(frozen=True)
class Choice:
    """Something that can be fired now. ``given`` None: its value is to be typed (see ``hint``)."""

    event: Event
    given: Given | None
    text: str
    hint: str = ""


@dataclass(frozen=True)
class Reason:
    """Why a command is not enabled.

    ``kind``: "phase", "synchronisation", "range", "requirement" or "synthesis".

    ``place`` is file and line of the requirement.
    """

    kind: str
    text: str
    place: str | None = None


@dataclass(frozen=True)
class CommandState:
    """A controllable event now. ``data`` is what would be sent; ``count`` how often it was."""

    event: Event
    reasons: tuple[Reason, ...]
    data: dict[str, Any] | None = None
    count: int | None = None

    @property
    def enabled(self) -> bool:
        return not self.reasons


@dataclass(frozen=True)
class Happening:
    """One event that took place: as in the event log of a running controller.

    ``time`` is that of the virtual clock, in seconds; None where there is none.
    """

    kind: str
    name: str
    value: Any = None
    index: int = 0
    outcome: str = "applied"
    detail: str | None = None
    time: float | None = None
    controllable: bool = field(default=False, kw_only=True)

    def document(self) -> dict[str, Any]:
        event: dict[str, Any] = {"kind": self.kind, "name": self.name}
        if self.index:
            event["index"] = self.index
        event["value"] = self.value
        found: dict[str, Any] = {"event": event, "outcome": self.outcome, "detail": self.detail}
        if self.time is not None:
            found["time"] = round(self.time, 6)
        return found


class Machine(Protocol):
    """A robot that is played. Machines refuse with :class:`Refused`, and then nothing changed."""

    supervisor: Supervisor

    @property
    def plant(self) -> Plant: ...

    @property
    def state(self) -> SystemState: ...

    @property
    def time(self) -> float | None:
        """Seconds on the virtual clock; None where time does not matter."""

    @property
    def stopped(self) -> str | None:
        """Why the controller made a safe stop, or None."""

    @property
    def typeable(self) -> Sequence[Event]:
        """The events that may be fired at all."""

    def choices(self) -> list[Choice]: ...

    def commands(self) -> list[CommandState]: ...

    def can(self, event: Event, given: Given | None) -> bool:
        """Whether it can happen now; without a value, whether any value of it can."""

    def fire(self, event: Event, given: Given) -> list[Happening]: ...

    def wait(self, seconds: float) -> list[Happening]: ...

    def path(self, condition: Expr) -> list[tuple[Event, Given]] | None:
        """The shortest way to where the condition holds; None if there is no such state."""

    def draw(self, rng: random.Random) -> tuple[Event, Given] | float | None:
        """What happens next at random: an event, seconds to wait, or None if nothing can."""

    def undo(self, count: int) -> None:
        """Take that many of the last ``fire`` and ``wait`` back; there are as many."""

    def restart(self) -> None: ...


def label(event: Event) -> str:
    """How an event is typed: ``grab.request``, ``Door.tau2``."""
    if event.kind.of_component:
        return f"{event.name}.{event.kind.value}{event.index}"
    return f"{event.name}.{event.kind.value}"


def few_values(event: Event) -> bool:
    return math.prod(len(p.values) for p in event.parameters) <= MANY


def draw_values(event: Event, rng: random.Random) -> tuple[Any, ...]:
    """One of the combinations that the parameters can have."""
    if math.prod(len(p.values) for p in event.parameters) <= 1000:
        return rng.choice(list(valuations(event)))
    return tuple(
        rng.choice([v for v in p.values if v is not None] if None in p.values else p.values)
        for p in event.parameters
    )


def brought(events: Sequence[Event]) -> list[Event]:
    """Those that a bare name means: a message, rather than that none came."""
    return [e for e in events if e.kind is not EventKind.TIMEOUT] or list(events)


def find_events(machine: Machine, text: str) -> list[Event]:
    """The events that a name can mean, best first. Raises InvalidLine if there is none.

    ``grab.request`` in full, ``grab`` for all events of it, or the beginning of either.
    """
    text = text.replace("^", "")
    events = machine.typeable
    for fits in (_is_label, _is_name, _begins_label):
        found = [event for event in events if fits(event, text)]
        if found:
            return found
    raise InvalidLine(_unknown(machine, text))


def exact_event(machine: Machine, text: str) -> Event:
    """The event with a name in full: ``grab.request``, ``Door.tau2``. Raises InvalidLine."""
    for event in machine.typeable:
        if _is_label(event, text):
            return event
    raise InvalidLine(_unknown(machine, text))


def _is_label(event: Event, text: str) -> bool:
    return text in (label(event), _key_label(event))


def _is_name(event: Event, text: str) -> bool:
    return text in (event.name, event.key)


def _begins_label(event: Event, text: str) -> bool:
    return _begins(label(event), text) or _begins(_key_label(event), text)


def _begins(whole: str, text: str) -> bool:
    """Whether a text begins a label, or each of its parts: ``gr.re`` for ``grab.request``."""
    parts, begun = whole.split("."), text.split(".")
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
    few = f"; there are {listing(labels)}" if len(labels) <= 8 else ""
    return f"there is no event or command '{text}'{few} (see help)"


def _key_label(event: Event) -> str:
    return label(event).replace(event.name, event.key, 1)
