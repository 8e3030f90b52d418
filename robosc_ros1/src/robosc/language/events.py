"""The tables of communications and their events, which every stage reads.

Some communications have *phases*: a service is idle or busy, an action idle, busy or cancelling, an
outgoing message with a timeout silent or fresh. The first phase is the initial one. Each event of
such a communication is possible in some phases and leads to one.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from enum import Enum
from typing import Literal, TypeAlias

from robosc.lazy_dataclasses import dataclass

Direction: TypeAlias = Literal["request", "response", "feedback"]
"""The data of a communication: what is sent, what comes back, and what is reported meanwhile."""

Folder: TypeAlias = Literal["msg", "srv", "action"]


class Kind(Enum):
    """The kinds of communication, seen from the component."""

    INCOMING = "incoming message"
    OUTGOING = "outgoing message"
    SERVICE = "service"
    ACTION = "action"
    SERVED_SERVICE = "outgoing service"
    SERVED_ACTION = "outgoing action"


class EventKind(Enum):
    """The kinds of event. ``word`` is the name in the language, in JSON documents and in logs."""

    REQUEST = "request"
    RESPONSE = "response"
    FEEDBACK = "feedback"
    ERROR = "error"
    CANCEL = "cancel"
    CANCELLED = "cancelled"
    TIMEOUT = "timeout"
    CALL = "call"
    ANSWER = "answer"
    REFUSAL = "refusal"
    PROGRESS = "progress"
    RECALL = "recall"
    TAU = "tau"
    AFTER = "after"

    @property
    def word(self) -> str:
        """The name for users: what the robot calls has the words of what the controller calls."""
        return _SERVED.get(self, self.value)

    @property
    def controllable(self) -> bool:
        """Whether the controller decides when it occurs."""
        return self in (EventKind.CANCEL, EventKind.TAU) or self.sent or self.served

    @property
    def sent(self) -> bool:
        """Whether it carries data that the controller gives."""
        return self in (EventKind.REQUEST, EventKind.ANSWER, EventKind.PROGRESS)

    @property
    def served(self) -> bool:
        """Whether it tells the robot what became of a call that it has made."""
        return self in (EventKind.ANSWER, EventKind.REFUSAL, EventKind.PROGRESS)

    @property
    def given(self) -> bool:
        """Whether provide statements may say what it carries: also of an error, where ROS has data
        for it."""
        return self.sent or self is EventKind.REFUSAL

    @property
    def restricted(self) -> bool:
        """Whether requirements on its communication are about it: what is refused is free."""
        return self.controllable and self is not EventKind.REFUSAL

    @property
    def to_component(self) -> bool:
        """Whether it goes to the component, as a command does: ``on request to``."""
        return self is EventKind.REQUEST or self.served

    @property
    def of_component(self) -> bool:
        """Whether it belongs to one transition of a component, not to a communication."""
        return self in (EventKind.TAU, EventKind.AFTER)

    @property
    def synchronised(self) -> bool:
        """Whether a component that mentions it can block it."""
        return self is EventKind.REQUEST or self.served or self.of_component

    @property
    def clocked(self) -> bool:
        """Whether the passing of time causes it."""
        return self in (EventKind.TIMEOUT, EventKind.AFTER)


_SERVED = {
    EventKind.CALL: "request",
    EventKind.ANSWER: "response",
    EventKind.REFUSAL: "error",
    EventKind.PROGRESS: "feedback",
    EventKind.RECALL: "cancel",
}


def command_key(key: str, kind: EventKind) -> str:
    """Return the key of a command in requirements, provided data and preferences: that of its
    communication, and of feedback and of the error to a call one of their own."""
    return f"{key}.{kind.word}" if kind in (EventKind.PROGRESS, EventKind.REFUSAL) else key


def words_of_events() -> tuple[str, ...]:
    """The names of events of communications, each once."""
    return tuple(dict.fromkeys(kind.word for kind in EventKind if not kind.of_component))


@dataclass(frozen=True, slots=True)
class Phases:
    """The phases of a communication, the initial one first, and those that are marked.

    Conditions of the plant name the others only: the initial phase is that of none of them.
    """

    names: tuple[str, ...]
    marked: tuple[str, ...]

    @property
    def active(self) -> tuple[str, ...]:
        """The phases that conditions name: ``grab.busy``, ``scan.fresh``."""
        return self.names[1:]


@dataclass(frozen=True, slots=True)
class EventSort:
    """An event of one kind of communication.

    ``sources`` are the phases in which it is possible, as far as the communication has them, and
    ``target`` the one it leads to, or the last one that it has; both are ignored where the
    communication has no phases. ``brings`` is the attribute that names the type
    of its value, of a request that of the data (None: it has no value); ``optional``: the value may
    be absent. ``with_timeout``: only communications with a timeout have this event.
    """

    kind: EventKind
    sources: tuple[str, ...] = ()
    target: str = ""
    brings: Direction | None = None
    optional: bool = False
    with_timeout: bool = False


@dataclass(frozen=True, slots=True)
class CommunicationSort:
    """One kind of communication: its events and phases, and its definition in ROS.

    ``name`` is its keyword, and its short name in JSON documents. ``phases_with_timeout``: it has
    ``phases`` only if it has a timeout. ``folder`` is that of its definition in a ROS package,
    ``parts`` are the attributes that correspond to the parts of the definition; of a message,
    the direction decides.
    """

    name: str
    folder: Folder
    parts: tuple[Direction, ...]
    events: tuple[EventSort, ...]
    phases: Phases | None = None
    phases_with_timeout: bool = False

    def events_of(self, timeout: bool) -> Iterator[EventSort]:
        """The events in model order; ``timeout`` says whether the communication has one."""
        return (e for e in self.events if timeout or not e.with_timeout)

    def phases_of(self, timeout: bool, heard: bool = False) -> Phases | None:
        """The phases; ``heard``: it is asked whether a message has ever arrived."""
        if heard:
            return _HEARD_WATCHED if timeout else _HEARD
        return self.phases if timeout or not self.phases_with_timeout else None

    @property
    def may_be_heard(self) -> bool:
        """Whether ``heard`` may be asked of it: it arrives unasked."""
        return self.phases is _WATCHED

    def event(self, kind: EventKind) -> EventSort | None:
        return next((e for e in self.events if e.kind is kind), None)

    def named(self, word: str) -> EventKind | None:
        """The kind of event that a word means for this communication; None if it has none."""
        return next((e.kind for e in self.events if e.kind.word == word), None)

    @property
    def command(self) -> EventKind | None:
        """The event with which the controller sends data."""
        return next((e.kind for e in self.events if e.kind.sent), None)

    @property
    def sends(self) -> Direction:
        """The data that the controller gives with its ``command``."""
        return "response" if self.served else "request"

    @property
    def sent(self) -> tuple[Direction, ...]:
        """All data that the controller gives."""
        return tuple(e.brings for e in self.events if e.kind.sent and e.brings is not None)

    @property
    def received(self) -> tuple[Direction, ...]:
        """The data that the controller gets."""
        return tuple(part for part in self.parts if part not in self.sent)

    @property
    def served(self) -> bool:
        """Whether the controller is what is called."""
        return any(e.kind.served for e in self.events)


_CALL = Phases(("idle", "busy"), marked=("idle",))
# What is cancelled goes on until its server says that it has ended: what moves is not idle.
_GOAL = Phases(("idle", "busy", "cancelling"), marked=("idle",))
# What was called off goes on until the controller answers.
_CALLED_GOAL = Phases(("idle", "busy", "ending"), marked=("idle",))
_WATCHED = Phases(("silent", "fresh"), marked=("silent", "fresh"))
_HEARD = Phases(("unheard", "heard"), marked=("unheard", "heard"))
_HEARD_WATCHED = Phases(("unheard", "fresh", "silent"), marked=("unheard", "fresh", "silent"))
_ARRIVED = ("unheard", "heard", "silent", "fresh")
_REQUEST = EventSort(EventKind.REQUEST, ("idle",), "busy", brings="request")
_RESPONSE = EventSort(EventKind.RESPONSE, ("busy",), "idle", brings="response")
# It has the answer that was not as expected; what failed otherwise has none.
_ERROR = EventSort(EventKind.ERROR, ("busy",), "idle", brings="response", optional=True)
_UNENDED = ("busy", "cancelling")

_UNANSWERED = ("busy", "ending")

_BUSY = ("busy", "ending")
"""A call that was cancelled is still to be answered: it is busy, too."""


def named_phases(phases: Sequence[str], name: str) -> tuple[str, ...]:
    """The phases that one name of a condition means, if they are several."""
    return _BUSY if name == "busy" and "ending" in phases else ()


def active_names(phases: Sequence[str]) -> Iterator[str]:
    """The names of conditions of which one holds in each phase but the first."""
    is_divided = "ending" in phases
    return (name for name in phases[1:] if not (is_divided and name in _BUSY[1:]))


ACTIVE = (*_GOAL.active, *_CALLED_GOAL.active[1:], *_WATCHED.active, *_HEARD.active)
"""The phases that conditions name: ``grab.busy``, ``scan.fresh``."""

COMMUNICATIONS: Mapping[Kind, CommunicationSort] = {
    Kind.INCOMING: CommunicationSort(
        "incoming", "msg", ("request",), (EventSort(EventKind.REQUEST, brings="request"),)
    ),
    Kind.OUTGOING: CommunicationSort(
        "outgoing",
        "msg",
        ("response",),
        (
            EventSort(EventKind.RESPONSE, _ARRIVED, "fresh", brings="response"),
            EventSort(EventKind.TIMEOUT, ("fresh",), "silent", with_timeout=True),
        ),
        _WATCHED,
        phases_with_timeout=True,
    ),
    Kind.SERVICE: CommunicationSort(
        "service", "srv", ("request", "response"), (_REQUEST, _RESPONSE, _ERROR), _CALL
    ),
    Kind.ACTION: CommunicationSort(
        "action",
        "action",
        ("request", "response", "feedback"),
        (
            _REQUEST,
            EventSort(EventKind.RESPONSE, _UNENDED, "idle", brings="response"),
            EventSort(EventKind.FEEDBACK, ("busy",), "busy", brings="feedback"),
            # A goal that is aborted has a result, one that is rejected or lost has none.
            EventSort(EventKind.ERROR, _UNENDED, "idle", brings="response", optional=True),
            EventSort(EventKind.CANCEL, ("busy",), "cancelling"),
            EventSort(EventKind.CANCELLED, ("cancelling",), "idle"),
        ),
        _GOAL,
    ),
    Kind.SERVED_SERVICE: CommunicationSort(
        "outgoing service",
        "srv",
        ("request", "response"),
        (
            EventSort(EventKind.CALL, ("idle",), "busy", brings="request"),
            EventSort(EventKind.ANSWER, ("busy",), "idle", brings="response"),
            EventSort(EventKind.REFUSAL, ("busy",), "idle"),
        ),
        _CALL,
    ),
    Kind.SERVED_ACTION: CommunicationSort(
        "outgoing action",
        "action",
        ("request", "response", "feedback"),
        (
            EventSort(EventKind.CALL, ("idle",), "busy", brings="request"),
            EventSort(EventKind.ANSWER, _UNANSWERED, "idle", brings="response"),
            EventSort(EventKind.PROGRESS, ("busy",), "busy", brings="feedback"),
            EventSort(EventKind.REFUSAL, _UNANSWERED, "idle"),
            EventSort(EventKind.RECALL, ("busy",), "ending"),
        ),
        _CALLED_GOAL,
    ),
}

FOLDERS: Mapping[str, Folder] = {sort.name: sort.folder for sort in COMMUNICATIONS.values()}
"""The folder of the definition of each kind of communication, by its keyword."""
