"""The plant: automata and requirements (docs/semantics.md, "The plant").

A state is a tuple of small integers, one per :class:`StateVariable`: an index into its values. A
state variable is a component's location, the phase of a communication, or a variable that
synthesis needs. They are in model order: for each component its location, its variables, then the
phases of its communications.

An event changes the state through its *phase step* (a service goes from idle to busy or back) and
through the *automata* of the components that synchronise on it. :func:`robosc.plant.step.outcome`
defines the effect of an event in a state; the engines compile it into faster forms.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from dataclasses import field
from enum import Enum
from functools import cached_property
from itertools import product
from typing import TypeAlias

from robosc.expr import identity_cache, tree, types
from robosc.language.events import EventKind, active_names, command_key, named_phases
from robosc.lazy_dataclasses import dataclass
from robosc.model.automata import Assignment
from robosc.model.entities import Robot
from robosc.plant import assumptions, counting, logic, partial_evaluation
from robosc.plant.data.view import FiniteView, reference_to
from robosc.source import Span

PlantState: TypeAlias = tuple[int, ...]


class VariableKind(Enum):
    LOCATION = "location"
    PHASE = "phase"
    DATA = "variable"
    TEST = "test"
    ASSUMPTION = "assumption"


ASSUMPTIONS = "the assumptions"
"""Stands for a component in an automaton of what the robot is assumed not to do."""


@dataclass(frozen=True, slots=True)
class StateVariable:
    """A variable of the plant's state: a location, a phase, data or a test of data; or the only
    state of an automaton of assumptions.

    ``name`` is the component's name (location), the communication's key (phase) or
    ``Component.variable``. ``values`` are the state names, the phases, or the variable's values in
    order: a tuple, a range for an integer, :class:`~robosc.plant.data.classes.Classes` for an
    unbounded type. ``marked`` are the indexes of marked values (None: all). ``labels`` are the
    texts for users where a value represents a class. ``test`` is the test of data, if the variable
    is one. ``starts`` are the possible initial indexes, ``initial`` first (empty: only
    ``initial``).
    """

    kind: VariableKind
    name: str
    values: Sequence[types.Value]
    initial: int
    marked: frozenset[int] | None = None
    labels: tuple[str, ...] | None = None
    test: tree.TestRef | None = None
    starts: tuple[int, ...] = ()

    @property
    def start_indexes(self) -> tuple[int, ...]:
        """The possible initial indexes, ``initial`` first."""
        return self.starts or (self.initial,)

    def shown(self, index: int) -> types.Value:
        """A value as users see it."""
        return self.values[index] if self.labels is None else self.labels[index]

    def phase(self, index: int) -> tree.Expr:
        """Return the condition that a communication is in a phase; the first is that of no
        other."""
        if index == 0:
            names = [str(value) for value in self.values]
            others = (
                tree.PhaseRef(self.name, name, within=named_phases(names, name))
                for name in active_names(names)
            )
            return logic.conjunction(map(logic.negation, others))
        return tree.PhaseRef(self.name, str(self.values[index]))

    def read(self, leaf: tree.Expr, index: int) -> types.Value:
        """Return the value of a leaf that reads this variable, where the variable has an index."""
        match leaf:
            case tree.StateRef(places=names) | tree.PhaseRef(places=names):
                return self.values[index] in names
        return self.values[index]

    @property
    def size(self) -> int:
        return len(self.values)


@dataclass(frozen=True, slots=True)
class EventParameter:
    """A part of an event's value, or a test of it, that guards or updates read.

    ``path`` is that of the ``ValueRef``; ``values`` are its possible values, in order. A path
    through an array has None as its last value, for an array that is too short: assignments that
    read it then leave their variable unchanged, and guards that read it do not hold
    (docs/semantics.md, "What is not there"). ``labels`` are the texts for users where a value
    represents a class. ``test`` is the test of data, if the parameter is one. ``optional``: the
    event may come without any value; then, too, None is the last value. ``renews``: it is no part
    of a value, but what some term of the state becomes.
    """

    path: tuple[str | int, ...]
    type: types.Type
    values: Sequence[types.Value | None]
    labels: tuple[str, ...] | None = None
    test: tree.TestRef | None = None
    optional: bool = False
    renews: bool = False

    def shown(self, value: types.Value | None) -> types.Value | None:
        """A value as users see it."""
        return value if self.labels is None else self.labels[self.values.index(value)]


@dataclass(frozen=True, slots=True)
class Edge:
    """A transition of a component on an event, from location ``source`` if ``guard`` holds.

    ``updates`` are the assignments to state variables: (index, right-hand side over the state
    before the event). ``assignments`` are those of the model, which the controller executes: they
    include data-only variables and the exact data. ``target`` is a location; ``enters``: the edge
    has a ``goto``, so that the location is entered even if it is the source. ``outer`` are the
    states with states in them, of those with transitions after a delay, that it enters or leaves.
    ``levels`` are those of its guards, 0 for the state's own: edges of one location with the same
    levels exclude each other.
    """

    source: int
    guard: tree.Expr | None
    updates: tuple[tuple[int, tree.Expr], ...]
    assignments: tuple[Assignment, ...]
    target: int
    enters: bool
    outer: tuple[str, ...]
    levels: tuple[int, ...]
    span: Span = field(compare=False, repr=False)


@dataclass(frozen=True, slots=True)
class LocalAutomaton:
    """A component's automaton restricted to one event; ``variable`` is the index of its location.

    The first edge from the current location whose guard holds is taken. If there is none, the
    component does not change, or blocks the event if ``blocking`` (a request or an internal
    transition).
    """

    component: str
    variable: int
    edges: tuple[Edge, ...]
    blocking: bool
    resets: bool = False
    """It is that of a lasting condition (:class:`~robosc.model.automata.Lasting`), which an event
    may set back; its edges lead to rest."""

    @property
    def expressions(self) -> Iterator[tree.Expr]:
        """The right-hand sides of updates and the guards of all edges."""
        for edge in self.edges:
            yield from (expr for _, expr in edge.updates)
            if edge.guard is not None:
                yield edge.guard

    @property
    def writes(self) -> Iterator[int]:
        """The state variables that an edge may change."""
        for edge in self.edges:
            yield from (variable for variable, _ in edge.updates)
            if edge.target != edge.source:
                yield self.variable


@dataclass(frozen=True, slots=True)
class PhaseStep:
    """The phases in which an event is possible (``sources``), and the one it leads to."""

    variable: int
    sources: tuple[int, ...]
    target: int


@dataclass(frozen=True)
class Event:
    """An event; with parameters it represents one event per combination of their values.

    ``name`` is the name for users: the communication, or for a tau the component. ``key`` is the
    communication's key, or the component for a tau. ``index`` is a tau's number, else 0.
    ``requirement`` is the condition under which the model's requirements allow it (None: always):
    the conjunction of them for a request; for a cancel, that one of them is violated (FALSE if the
    action has none). It is not part of the plant. ``requirements`` are the indexes of these
    requirements in ``Robot.requirements``.

    ``path`` of the transition of a component is where it leads, ``idle->busy``, with its line if
    others lead there as well.

    ``known`` are the indexes of the parameters that the supervisor knows before it decides: parts
    of the data that another controller sends, and tests of them. There is one event for each
    combination of their values, which its parameters then have as their only ones; ``index``
    numbers these events from 1, and ``whole`` is the request for all data.
    """

    kind: EventKind
    name: str
    key: str
    index: int
    controllable: bool
    parameters: tuple[EventParameter, ...]
    phase: PhaseStep | None
    automata: tuple[LocalAutomaton, ...]
    requirement: tree.Expr | None
    requirements: tuple[int, ...]
    known: tuple[int, ...] = ()
    path: str = ""
    whole: Event | None = field(default=None, compare=False, repr=False)
    span: Span = field(compare=False, repr=False, kw_only=True)

    @property
    def command(self) -> str:
        """The key by which requirements, provided data and preferences name it as a command."""
        return command_key(self.key, self.kind)

    @property
    def identity(self) -> tuple[EventKind, str, int]:
        """The key of an event, unique in its plant."""
        return self.kind, self.key, self.index

    @property
    def branches(self) -> bool:
        """Whether it is a command of which the environment chooses the outcome."""
        return self.controllable and len(self.parameters) > len(self.known)

    @property
    def data(self) -> partial_evaluation.PartValues:
        """The values of the parameters that are known."""
        return {self.parameters[i].path: self.parameters[i].values[0] for i in self.known}

    @cached_property
    def writes(self) -> frozenset[int]:
        """The indexes of the state variables that it may change."""
        phase = () if self.phase is None else (self.phase.variable,)
        return frozenset(phase).union(*(automaton.writes for automaton in self.automata))


@dataclass(frozen=True, slots=True)
class PlantGoal:
    """What must remain possible (:class:`~robosc.model.entities.Goal`), in terms of the plant.

    ``index`` is that of the goal in ``Robot.goals``.
    """

    condition: tree.Expr
    origin: tree.Expr
    along: tree.Expr
    index: int

    @property
    def conditions(self) -> tuple[tree.Expr, ...]:
        """All that it reads."""
        return self.condition, self.along, self.origin


@dataclass(frozen=True)
class Plant:
    """The uncontrolled system, with its requirements and the model it was made from.

    ``invariants`` are the conditions of state requirements, each with its index in
    ``Robot.requirements``; they must hold in every state (``never e`` is ``!e``). ``events`` are in
    model order: for each component those of its communications (request, response, feedback, error,
    cancel), then its taus. ``view`` is the finite view of the data. ``goals`` are what must remain
    possible beside the marked states. ``lasting`` are the conditions of assumptions on states, each
    with its index in ``Robot.assumptions``. ``restrictions`` are what is assumed of events, over
    the data of the model.
    """

    robot: Robot
    variables: tuple[StateVariable, ...]
    events: tuple[Event, ...]
    invariants: tuple[tuple[tree.Expr, int], ...]
    view: FiniteView = field(compare=False, repr=False)
    goals: tuple[PlantGoal, ...] = ()
    lasting: tuple[tuple[tree.Expr, int], ...] = ()
    restrictions: assumptions.Restrictions = field(default_factory=dict, compare=False, repr=False)

    @cached_property
    def variable_index(self) -> dict[tuple[VariableKind, str], int]:
        return {(variable.kind, variable.name): i for i, variable in enumerate(self.variables)}

    def variable_of(self, leaf: tree.Expr) -> int | None:
        """Return the state variable that a leaf reads; None if it reads no state."""
        match leaf:
            case tree.TestRef(name=name):
                return self.variable_index[VariableKind.TEST, name]
            case tree.VariableRef(component=component, variable=name):
                return self.variable_index[VariableKind.DATA, f"{component}.{name}"]
            case tree.StateRef(component=component):
                return self.variable_index[VariableKind.LOCATION, component]
            case tree.PhaseRef(communication=key):
                return self.variable_index[VariableKind.PHASE, key]
        return None

    def sizes(self, variables: Iterable[int]) -> tuple[int, ...]:
        """Return the number of values of each of some state variables."""
        return tuple(self.variables[variable].size for variable in variables)

    def leaf_of(self, variable: StateVariable) -> tree.VariableRef | tree.TestRef:
        """Return the leaf that reads a variable or a test of data."""
        return variable.test or reference_to(self.robot.variables[variable.name])

    @cached_property
    def supports(self) -> identity_cache.IdentityCache[tuple[int, ...]]:
        """A cache: the indexes of the state variables that each condition reads."""
        return identity_cache.IdentityCache()

    @cached_property
    def lasting_counts(self) -> identity_cache.IdentityCache[tuple[tree.Expr, ...]]:
        """A cache: the counts that guards may use, for the conditions of state requirements."""
        return identity_cache.IdentityCache()

    @cached_property
    def lasting_conditions(self) -> identity_cache.IdentityCache[list[tree.Expr]]:
        """A cache: what keeps state requirements, for their conditions."""
        return identity_cache.IdentityCache()

    @cached_property
    def comparisons(self) -> identity_cache.IdentityCache[tuple[tree.Binary, ...]]:
        """A cache: the comparisons of the state in each condition."""
        return identity_cache.IdentityCache()

    @cached_property
    def tighter_counts(self) -> tuple[tree.Expr, ...]:
        """For each count in a state requirement, the condition that it may rise by one.

        It is sufficient for events that bring one component into the counted state.
        """
        found = [
            counting.tighter(count)
            for condition, _ in self.invariants
            for count in counting.counts(condition, self.robot)
        ]
        return tuple(dict.fromkeys(expr for expr in found if expr is not None))

    @cached_property
    def initial(self) -> PlantState:
        """The initial state with the default values of all parameters."""
        return tuple(variable.initial for variable in self.variables)

    @property
    def initial_states(self) -> Iterator[PlantState]:
        """Yield the initial states for all values of parameters, that of the defaults first."""
        return product(*(variable.start_indexes for variable in self.variables))

    def is_initial(self, state: PlantState) -> bool:
        return all(
            value in variable.start_indexes
            for variable, value in zip(self.variables, state, strict=True)
        )

    def is_marked(self, state: PlantState) -> bool:
        return all(
            variable.marked is None or value in variable.marked
            for variable, value in zip(self.variables, state, strict=True)
        )
