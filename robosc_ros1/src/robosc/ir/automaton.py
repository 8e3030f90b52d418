"""The plant: what every backend works on (docs/semantics.md, "The plant").

A state is a tuple of small integers, one per :class:`StateVariable`: an index into its values. A
state variable is a component's location, the phase of a communication, or a variable that
synthesis needs. They stand in model order: per component its location, then its variables, then the
phases of its communications.

An event changes the state through its *phase* (a service goes from idle to busy or back) and
through its *automata*, those of the components that synchronise on it. What an event does in a
state is defined by :func:`robosc.ir.step.outcome`; engines compile the same into faster forms.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field
from enum import Enum
from functools import cached_property
from itertools import product
from typing import Literal, TypeAlias

from robosc.ir.by_identity import ByIdentity
from robosc.ir.counting import counts, tighter
from robosc.ir.finite.view import FiniteView
from robosc.ir.formulas import exact
from robosc.model.entities import Assignment, EventKind, Robot
from robosc.model.expr import Expr, TestRef, ValueRef
from robosc.model.traversal import walk
from robosc.model.types import NoneType, Type, Value
from robosc.source import Span

__all__ = [
    "Edge", "Event", "LocalAutomaton", "EventParameter", "PhaseStep", "Plant", "PlantState",
    "StateVariable", "VariableKind", "is_optional", "value_parts", "value_type",
]  # fmt: skip

PlantState: TypeAlias = tuple[int, ...]


class VariableKind(Enum):
    LOCATION = "location"
    PHASE = "phase"
    DATA = "variable"
    TEST = "test"


@dataclass(frozen=True, slots=True)
class StateVariable:
    """A variable of the plant's state: a location, a phase, data or a test of data.

    ``name`` is the component's (location), the communication's key (phase) or
    ``Component.variable``. ``values`` are the state names, the phases, or the variable's
    values in order: a tuple, a range for an integer, classes for what is not finite. ``marked`` are
    the indexes at which the variable is marked; None: all (a variable). ``labels`` are what users
    see where values only represent a class. ``test`` is what a test reads. ``starts`` are the
    indexes that it can have at the start, ``initial`` first; empty: only that.
    """

    kind: VariableKind
    name: str
    values: Sequence[Value]
    initial: int
    marked: frozenset[int] | None = None
    labels: tuple[str, ...] | None = None
    test: TestRef | None = None
    starts: tuple[int, ...] = ()

    @property
    def start_indexes(self) -> tuple[int, ...]:
        """The indexes that it can have at the start, ``initial`` first."""
        return self.starts or (self.initial,)

    def shown(self, index: int) -> Value:
        """A value as users see it."""
        return self.values[index] if self.labels is None else self.labels[index]

    @property
    def size(self) -> int:
        return len(self.values)


@dataclass(frozen=True, slots=True)
class EventParameter:
    """A part of an event's value that a synthesis variable or guard takes, or a test of data.

    ``path`` is that of the ``ValueRef``; ``values`` are all it can be, in order. ``None`` stands
    last for a path through an array, which may be shorter than the index: assignments that read it
    then leave their variable, and guards that read it do not hold (docs/semantics.md, "What is not
    there"). ``labels`` are what users see where values only represent a class. ``test`` is what a
    test reads.
    ``optional`` says that there may be no value at all; then, too, ``None`` stands last.
    """

    path: tuple[str | int, ...]
    type: Type
    values: Sequence[Value | None]
    labels: tuple[str, ...] | None = None
    test: TestRef | None = None
    optional: bool = False

    def shown(self, value: Value | None) -> Value | None:
        """A value as users see it."""
        return value if self.labels is None else self.labels[self.values.index(value)]


@dataclass(frozen=True, slots=True)
class Edge:
    """One way in which a component takes part in an event: in location ``source``, if ``guard``
    holds.

    ``updates`` assign state variables: (index, right-hand side over the state before the event).
    ``assignments`` are those of the model, for the controller at run time: data-only variables
    among them, and data exactly. ``target`` is a location; ``enters`` says whether it is entered
    (by ``goto``), be it from itself. ``level`` says whether it is a transition of the state, of
    the whole automaton, or two of them taken together.
    """

    source: int
    guard: Expr | None
    updates: tuple[tuple[int, Expr], ...]
    assignments: tuple[Assignment, ...]
    target: int
    enters: bool
    level: Literal["state", "automaton", "both"]
    span: Span = field(compare=False, repr=False)


@dataclass(frozen=True, slots=True)
class LocalAutomaton:
    """A component's automaton as one event concerns it; ``variable`` is its location's index.

    In a state, the first edge from its location whose guard holds is taken. Where there is none,
    the component stays as it is, or blocks the event if ``blocking`` (a request, an
    internal transition).
    """

    component: str
    variable: int
    edges: tuple[Edge, ...]
    blocking: bool

    @property
    def expressions(self) -> Iterator[Expr]:
        """The guards and the right-hand sides of updates of all edges."""
        for edge in self.edges:
            if edge.guard is not None:
                yield edge.guard
            yield from (expr for _, expr in edge.updates)


@dataclass(frozen=True, slots=True)
class PhaseStep:
    """A communication's own automaton: possible in phases ``sources``, leads to ``target``."""

    variable: int
    sources: tuple[int, ...]
    target: int


@dataclass(frozen=True, slots=True)
class Event:
    """One event; with parameters it stands for one event per combination of their values.

    ``name`` is what users see: the communication, or for a tau the component. ``key`` is
    the communication's key, or the component for a tau. ``index`` is a tau's number, else 0.
    ``requirement`` is what the model's requirements allow (None: always): the conjunction for a
    request; for a cancel, that one of them is violated, or FALSE if the action has none. It is no
    part of the plant. ``requirements`` are the indexes in ``Robot.requirements`` that speak of it.
    """

    kind: EventKind
    name: str
    key: str
    index: int
    controllable: bool
    parameters: tuple[EventParameter, ...]
    phase: PhaseStep | None
    automata: tuple[LocalAutomaton, ...]
    requirement: Expr | None
    requirements: tuple[int, ...]
    span: Span = field(compare=False, repr=False)

    @property
    def identity(self) -> tuple[EventKind, str, int]:
        """What identifies an event of a plant."""
        return self.kind, self.key, self.index


@dataclass(frozen=True)
class Plant:
    """The uncontrolled system, its requirements beside it, and the model it came from.

    ``invariants`` are the conditions of state requirements as they must hold (``never e`` is
    ``!e``), each with its index in ``Robot.requirements``. Events stand in model order: per
    component and communication request, response, feedback, error, cancel; a component's taus
    after its communications. ``view`` is what the plant knows of data.
    """

    robot: Robot
    variables: tuple[StateVariable, ...]
    events: tuple[Event, ...]
    invariants: tuple[tuple[Expr, int], ...]
    view: FiniteView = field(compare=False, repr=False)

    @cached_property
    def variable_index(self) -> dict[tuple[VariableKind, str], int]:
        return {(variable.kind, variable.name): i for i, variable in enumerate(self.variables)}

    @cached_property
    def writes(self) -> tuple[frozenset[int], ...]:
        """Per event, the variables that it may change."""
        return tuple(_writes(event) for event in self.events)

    def number(self, event: Event) -> int:
        """The place of an event among all."""
        return next(number for number, one in enumerate(self.events) if one is event)

    @cached_property
    def supports(self) -> ByIdentity[tuple[int, ...]]:
        """The state variables that conditions read."""
        return ByIdentity()

    @cached_property
    def lasting_counts(self) -> ByIdentity[tuple[Expr, ...]]:
        """What guards may count, for the conditions of state requirements."""
        return ByIdentity()

    @cached_property
    def tighter_counts(self) -> tuple[Expr, ...]:
        """For each count in a state requirement, that there is room for one more.

        An event that brings one component into the counted state keeps the requirement then.
        """
        found = [tighter(count) for condition, _ in self.invariants for count in counts(condition)]
        return tuple(dict.fromkeys(expr for expr in found if expr is not None))

    @cached_property
    def initial(self) -> PlantState:
        """The initial state where all parameters have their defaults."""
        return tuple(variable.initial for variable in self.variables)

    @property
    def initial_states(self) -> Iterator[PlantState]:
        """All initial states, that of the defaults first: parameters are not known beforehand."""
        return product(*(variable.start_indexes for variable in self.variables))

    def is_marked(self, state: PlantState) -> bool:
        return all(
            variable.marked is None or value in variable.marked
            for variable, value in zip(self.variables, state, strict=True)
        )


def _writes(event: Event) -> frozenset[int]:
    variables = set() if event.phase is None else {event.phase.variable}
    for automaton in event.automata:
        for edge in automaton.edges:
            variables.update(variable for variable, _ in edge.updates)
            if edge.target != edge.source:
                variables.add(automaton.variable)
    return frozenset(variables)


def is_optional(robot: Robot, event: Event) -> bool:
    """Whether an event that brings a value may come without it."""
    communication = robot.communications.get(event.key)
    sort = None if communication is None else communication.sort.event(event.kind)
    return sort is not None and sort.optional


def value_type(robot: Robot, event: Event) -> Type:
    """The type of the value that comes with an event; ``none`` if an optional one is not read."""
    if event.kind.of_component or (is_optional(robot, event) and not value_parts(event)):
        return NoneType()
    return robot.communications[event.key].value_type(event.kind)


def value_parts(event: Event) -> dict[tuple[str | int, ...], Type]:
    """The parts of an event's value that transitions read, data-only variables included."""
    found: dict[tuple[str | int, ...], Type] = {}
    for automaton in event.automata:
        for edge in automaton.edges:
            readers = [a.value for a in edge.assignments]
            for expr in readers + ([exact(edge.guard)] if edge.guard is not None else []):
                for part in walk(expr):
                    if isinstance(part, ValueRef):
                        found.setdefault(part.path, part.type)
    return found
