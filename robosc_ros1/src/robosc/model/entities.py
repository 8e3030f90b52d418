"""The resolved, typed model of one robot.

Imported components stand here like local ones, their identifiers prefixed. A communication is
referred to by its *key* ``Component.communication``. The span of an entity with a name is that of
the name; of others, that of the whole text.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Iterator, Mapping
from dataclasses import field
from functools import cached_property
from typing import Literal, TypeAlias

from robosc.expr import traversal, tree, types
from robosc.expr.identity_cache import IdentityCache
from robosc.language import events
from robosc.lazy_dataclasses import dataclass
from robosc.model import automata, diagnostics
from robosc.names import Copy
from robosc.runtime.core.places import stage_of
from robosc.source import Source, Span
from robosc.syntax.nodes import ExprNode, Repeated


@dataclass(frozen=True, slots=True)
class Binding:
    """The ROS interface of a communication.

    ``package``/``type`` name it as the target's tools do, without folder: ``std_msgs``/``Bool``,
    ``actionlib``/``TestAction`` (an action's ``type`` is the file name before ``.action``).
    ``request_field``, ``response_field``, ``feedback_field`` name the one data field that carries a
    basic type, or an enum from one; None for objects, ``none`` and where the definition is not
    installed. A message has its field in ``request_field`` (incoming) or ``response_field``
    (outgoing). ``found`` says whether the installed definition was checked, ``light`` (which
    follows from that) whether a message has few bytes whatever is in it.
    """

    package: str
    type: str
    found: bool
    request_field: str | None = None
    response_field: str | None = None
    feedback_field: str | None = None
    light: bool = field(default=False, compare=False)


@dataclass(frozen=True, slots=True)
class Communication:
    """A message, service or action of a component.

    ``timeout`` is the silence after which a message is silent, or the deadline of a service or
    action; ``within`` that of an accepted goal; ``max_age`` the greatest age of a message on
    arrival; ``expect`` what must hold of a response. ``rate`` is how often a command is sent, in
    Hz, or ``once``; ``goals`` is ``replace`` if a goal may replace a busy one; ``stop`` is ``none``
    if what is sent to the topic moves nothing. ``frames`` are those of a transform, from and to,
    which ``rate`` limits. ``heard``: somebody asks whether it ever arrived.
    ``request`` is what the controller sends, ``response`` what it receives. ``identifier`` is the
    name in ROS, prefix included.
    """

    name: str
    component: str
    kind: events.Kind
    identifier: str
    request: types.Type
    response: types.Type
    feedback: types.Type
    binding: Binding
    timeout: tree.Expr | None = None
    within: tree.Expr | None = None
    max_age: tree.Expr | None = None
    expect: tree.Expr | None = None
    rate: float | str | None = None
    goals: str | None = None
    stop: str | None = None
    frames: tuple[str, str] | None = None
    heard: bool = False
    span: Span = automata.span_field()

    @property
    def key(self) -> str:
        return f"{self.component}.{self.name}"

    @property
    def ros_name(self) -> str:
        """The identifier as names are compared: ``/go`` is ``go``, and ``~/go`` is ``~go``."""
        name = self.identifier.lstrip("/")
        return f"~{name[2:]}" if name.startswith("~/") else name

    @property
    def sort(self) -> events.CommunicationSort:
        """The row of the language's table for communications of this kind."""
        return events.COMMUNICATIONS[self.kind]

    @property
    def phases(self) -> events.Phases | None:
        return self.sort.phases_of(self.timeout is not None, self.heard)

    def phase_after(self, event: events.EventSort) -> str:
        """The phase to which an event leads; of a message without timeout, *heard*."""
        names = () if self.phases is None else self.phases.names
        return event.target if event.target in names or not names else names[-1]

    @property
    def sent(self) -> types.Type:
        """The type of the data that its command carries."""
        sent: types.Type = getattr(self, self.sort.sends)
        return sent

    @property
    def commands(self) -> Iterator[Command]:
        """What the controller sends with data."""
        return (Command(self, e.kind) for e in self.sort.events if e.kind.given)

    def value_type(self, event: events.EventKind) -> types.Type:
        """The type of the value of an event of this communication, or ``none``."""
        found = self.sort.event(event)
        if found is None or found.brings is None:
            return types.NoneType()
        brought: types.Type = getattr(self, found.brings)
        return brought


@dataclass(frozen=True, slots=True)
class Command:
    """A request, or the answer or the feedback of a call that is served, or the error to it, and
    what it carries."""

    communication: Communication
    kind: events.EventKind

    @property
    def key(self) -> str:
        return events.command_key(self.communication.key, self.kind)

    @property
    def direction(self) -> events.Direction:
        """The part of the communication that it is."""
        event = self.communication.sort.event(self.kind)
        assert event is not None
        return event.brings or "response"  # an error has no value, but the data of a response

    @property
    def type(self) -> types.Type:
        type_: types.Type = getattr(self.communication, self.direction)
        return type_

    @property
    def field(self) -> str | None:
        """The data field that carries its data, if one does."""
        field: str | None = getattr(self.communication.binding, f"{self.direction}_field")
        return field


def display_names(communications: Mapping[str, Communication]) -> dict[str, str]:
    """The names shown to users, by key, also of commands: ``Component.name`` only where ``name``
    is ambiguous."""
    count = Counter(communication.name for communication in communications.values())
    names = {key: c.name if count[c.name] == 1 else key for key, c in communications.items()}
    for command in (command for c in communications.values() for command in c.commands):
        names.setdefault(
            command.key, events.command_key(names[command.communication.key], command.kind)
        )
    return names


@dataclass(frozen=True, slots=True)
class Component:
    """A component, of its ``library``; ``copy`` is which one of several of a kind it is."""

    name: str
    communications: tuple[Communication, ...]
    behaviour: automata.Behaviour
    """Without states where the model gives none."""
    library: str | None
    copy: Copy | None = None
    span: Span = automata.span_field()

    @property
    def declared(self) -> str:
        """Its name where it is declared: each of several of a kind is there under that of all."""
        return self.name if self.copy is None else self.copy.family

    @property
    def variables(self) -> tuple[automata.Variable, ...]:
        return self.behaviour.variables

    @property
    def states(self) -> tuple[automata.State, ...]:
        return self.behaviour.states

    @property
    def transitions(self) -> Iterator[automata.Transition]:
        """Those of every state, then state by state."""
        return self.behaviour.all_transitions


@dataclass(frozen=True, slots=True)
class Requirement:
    """A requirement on commands (by key) or on all states.

    ``text`` is its text on one line. ``to_start``: it restricts the request of an action, and is no
    reason to cancel it. ``to_cancel``: it is only such a reason. ``on_data``: it is about the data
    of its command. ``implied``: nobody has written it, it follows from what ROS is. ``repeated``:
    which copy it is in a ``for``. ``id`` is the first word of its title, empty without one; the
    text begins with the title.
    """

    kind: Literal["needs", "disables", "never", "always"]
    communications: tuple[str, ...]
    condition: tree.Expr
    text: str
    to_start: bool = False
    to_cancel: bool = field(default=False, kw_only=True)
    on_data: bool = False
    implied: bool = False
    id: str = field(default="", kw_only=True)
    repeated: Repeated | None = field(default=None, kw_only=True)
    span: Span = automata.span_field()

    def concerns(self, kind: events.EventKind) -> bool:
        """Whether it is about events of a kind, of its communications."""
        return not (self.to_start if kind is events.EventKind.CANCEL else self.to_cancel)

    @property
    def forbids(self) -> bool:
        """Whether the condition must not hold; otherwise it must."""
        return self.kind in ("disables", "never")


@dataclass(frozen=True, slots=True)
class Goal:
    """What must remain possible: ``requirement possible condition from origin while along``.

    Under control, from every state in which ``origin`` holds (None: from every state) one in which
    ``condition`` holds can be reached; in the states before it ``along`` holds (None: it is not
    asked). ``text`` is the requirement on one line, ``id`` as of other requirements.
    """

    condition: tree.Expr
    origin: tree.Expr | None
    along: tree.Expr | None
    text: str
    id: str = ""
    span: Span = automata.span_field()

    @property
    def conditions(self) -> tuple[tree.Expr, ...]:
        """All that it reads."""
        return tuple(e for e in (self.condition, self.origin, self.along) if e is not None)


@dataclass(frozen=True, slots=True)
class Assumption:
    """What the robot does not do (docs/semantics.md, "Assumptions").

    ``needs``: the outgoing message or answer ``communication`` (a key) comes only where
    ``condition`` holds, which may read its ``value``. Otherwise no response and no feedback leads
    from a state in which the condition holds to one in which it does not; ``never`` is ``always``
    with the condition negated. ``text`` is the assumption on one line, ``id`` as of requirements.
    """

    kind: Literal["needs", "never", "always"]
    communication: str | None
    condition: tree.Expr
    text: str
    id: str = ""
    span: Span = automata.span_field()


@dataclass(frozen=True, slots=True)
class DataObject:
    """Values for named fields; fields that are not named keep their defaults."""

    fields: tuple[tuple[str, Data], ...]


@dataclass(frozen=True, slots=True)
class DataArray:
    """Values for the elements of an array."""

    elements: tuple[Data, ...]
    span: Span = automata.span_field()


Data: TypeAlias = DataObject | DataArray | tree.Expr


def data_expressions(data: Data) -> Iterator[tree.Expr]:
    """The expressions in provided data, in source order."""
    match data:
        case DataObject(fields=fields):
            for _, inner in fields:
                yield from data_expressions(inner)
        case DataArray(elements=elements):
            for inner in elements:
                yield from data_expressions(inner)
        case _:
            yield data


@dataclass(frozen=True, slots=True)
class Provide:
    """The data that a command (by key) carries; it is enabled only where ``condition`` holds."""

    communication: str
    data: Data
    condition: tree.Expr | None
    span: Span = automata.span_field()

    @property
    def expressions(self) -> Iterator[tree.Expr]:
        """Those in its data, and its condition, if it has one."""
        yield from data_expressions(self.data)
        if self.condition is not None:
            yield self.condition

    @property
    def corrects(self) -> bool:
        """Whether it reads the data that another controller sends."""
        return any(map(traversal.reads_value, self.expressions))

    @property
    def deciding(self) -> tree.Expr | None:
        """Its condition where that decides about the state: one of a correction does not."""
        return None if self.corrects else self.condition


@dataclass(frozen=True, slots=True)
class Preference:
    """While a ``preferred`` command is enabled, none of those in ``over`` is sent."""

    preferred: tuple[str, ...]
    over: tuple[str, ...]
    span: Span = automata.span_field()


ConditionReader: TypeAlias = Callable[[ExprNode, diagnostics.Report], tree.Expr | None]
"""Types a condition that somebody asks of the robot; returns None after a reported error."""


@dataclass(frozen=True)
class Robot:
    """The whole model in source order; an imported component stands at its import.

    A library is resolved as a robot without requirements, data and preferences.
    """

    name: str
    components: tuple[Component, ...]
    requirements: tuple[Requirement, ...]
    provides: tuple[Provide, ...]
    preferences: tuple[Preference, ...] = ()
    parameters: tuple[tree.RosParameter, ...] = ()
    stop: str | None = None
    """The key of the message that is sent at a safe stop and when the node ends."""
    goals: tuple[Goal, ...] = ()
    assumptions: tuple[Assumption, ...] = ()
    lasting: tuple[automata.Lasting, ...] = ()
    goes_on: bool = False
    """``stop with nothing``: it may go on with its last commands when the node ends."""
    supervises: bool = False
    """Whether the data of commands are those that another controller sends."""
    sources: tuple[Source, ...] = field(default=(), compare=False, repr=False)
    """The texts of the model: its own file, then the libraries that it needs, by name."""
    conditions: ConditionReader = field(compare=False, repr=False, kw_only=True)
    """Reads conditions with the names of the model's own requirements."""
    span: Span = automata.span_field()

    @property
    def transitions(self) -> Iterator[tuple[Component, automata.Transition]]:
        """Those of all components, each with its component."""
        return (
            (component, taken) for component in self.components for taken in component.transitions
        )

    @cached_property
    def communications(self) -> dict[str, Communication]:
        """All communications by key, in model order."""
        return {c.key: c for component in self.components for c in component.communications}

    @cached_property
    def commands(self) -> dict[str, Command]:
        """What the controller sends with data, by key."""
        return {c.key: c for each in self.communications.values() for c in each.commands}

    @cached_property
    def counts(self) -> tuple[IdentityCache[tree.Count | None], IdentityCache[tuple[int, int]]]:
        """Caches: the count that a condition expands, and sizes that tell whether it may be one."""
        return IdentityCache(), IdentityCache()

    @cached_property
    def variables(self) -> dict[str, automata.Variable]:
        """All variables by key, in model order."""
        return {v.key: v for component in self.components for v in component.variables}

    @property
    def persistent(self) -> dict[str, automata.Variable]:
        """The variables that keep their values over the node's end, by key."""
        return {key: variable for key, variable in self.variables.items() if variable.persistent}

    @cached_property
    def stages(self) -> tuple[str, ...]:
        """``Component.state stage`` for each stage of a state that performs a command, as documents
        tell them outside of the states."""
        return tuple(
            f"{component.name}.{state.name}"
            for component in self.components
            for state in component.states
            if stage_of(state.name)
        )

    @cached_property
    def transforms(self) -> dict[tuple[str, str], tuple[str, ...]]:
        """The keys of transforms by their frames, from and to."""
        found: dict[tuple[str, str], tuple[str, ...]] = {}
        for one in self.communications.values():
            if one.frames is not None:
                found[one.frames] = (*found.get(one.frames, ()), one.key)
        return found

    @cached_property
    def yields_to(self) -> dict[str, tuple[str, ...]]:
        """The keys of commands that are preferred to a command, by its key."""
        found: dict[str, dict[str, None]] = {}
        for preference in self.preferences:
            for key in preference.over:
                found.setdefault(key, {}).update(dict.fromkeys(preference.preferred))
        return {key: tuple(preferred) for key, preferred in found.items()}

    @cached_property
    def performed(self) -> dict[str, list[tuple[str, str]]]:
        """The states that perform a command, with their components, by its key."""
        found: dict[str, list[tuple[str, str]]] = {}
        for component in self.components:
            for outer in component.behaviour.composites:
                if outer.performs is not None:
                    found.setdefault(outer.performs, []).append((component.name, outer.name))
        return found

    @cached_property
    def together(self) -> dict[str, frozenset[str]]:
        """The components that perform a command, by its key, where several do; none blocks it."""
        performers = {key: {c for c, _ in found} for key, found in self.performed.items()}
        return {key: frozenset(names) for key, names in performers.items() if len(names) > 1}

    @cached_property
    def corrected(self) -> frozenset[str]:
        """The keys of the commands of which all provide statements are corrections."""
        return frozenset(p.communication for p in self.provides if p.corrects)

    @cached_property
    def display_names(self) -> dict[str, str]:
        """The names of communications shown to users, by key."""
        return display_names(self.communications)

    def component(self, name: str) -> Component:
        """The component of a name, which must exist."""
        return next(c for c in self.components if c.name == name)

    def decides(self, word: str, name: str) -> bool:
        """Whether the controller decides when an event occurs, given by what logs have for it.

        ``name`` is the name, as shown to users, of its communication, or that of its component.
        """
        for communication in self.communications.values():
            if self.display_names[communication.key] == name:
                kind = communication.sort.named(word)
                return kind is not None and kind.controllable
        return word == events.EventKind.TAU.word
