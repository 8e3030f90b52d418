"""From the model to the plant (SEMANTICS section 1)."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass

from robosc.errors import StateSpaceError
from robosc.ir.automaton import (
    Edge,
    Event,
    LocalAutomaton,
    Parameter,
    PhaseStep,
    Plant,
    StateVariable,
    VariableKind,
)
from robosc.ir.expr import conjunction, disjunction, negation
from robosc.model.entities import (
    Assignment,
    Behaviour,
    Communication,
    Component,
    EventKind,
    Kind,
    ResultTransition,
    Robot,
    Tau,
)
from robosc.model.expr import TRUE, Expr, ValueRef, walk
from robosc.model.types import Type, Value, domain

__all__ = ["lower"]

_IDLE, _BUSY = 0, 1
_MOST_VALUES = 2**20
"""Of one variable or of one part of an event's value."""

EVENTS_OF: dict[Kind, tuple[EventKind, ...]] = {
    Kind.OUTGOING: (EventKind.RESPONSE,),
    Kind.INCOMING: (EventKind.REQUEST,),
    Kind.SERVICE: (EventKind.REQUEST, EventKind.RESPONSE, EventKind.ERROR),
    Kind.ACTION: (
        EventKind.REQUEST,
        EventKind.RESPONSE,
        EventKind.FEEDBACK,
        EventKind.ERROR,
        EventKind.CANCEL,
    ),
}

_PHASES = {
    EventKind.REQUEST: (_IDLE, _BUSY),
    EventKind.RESPONSE: (_BUSY, _IDLE),
    EventKind.FEEDBACK: (_BUSY, _BUSY),
    EventKind.ERROR: (_BUSY, _IDLE),
    EventKind.CANCEL: (_BUSY, _IDLE),
}


def lower(robot: Robot) -> Plant:
    """The plant of a model without errors.

    Raises:
        StateSpaceError: a range is so large that it could not even be written down.
    """
    context = _Context.of(robot)
    events = tuple(
        event for component in robot.components for event in context.events_of(component)
    )
    invariants = tuple(
        (negation(r.condition) if r.kind == "never" else r.condition, index)
        for index, r in enumerate(robot.requirements)
        if r.kind in ("never", "always")
    )
    return Plant(robot, context.variables, events, invariants)


def _state_variables(robot: Robot) -> Iterator[StateVariable]:
    for component in robot.components:
        behaviour = component.behaviour
        if behaviour is not None:
            states = behaviour.states
            yield StateVariable(
                VariableKind.LOCATION,
                component.name,
                tuple(s.name for s in states),
                next(i for i, s in enumerate(states) if s.initial),
                frozenset(i for i, s in enumerate(states) if s.marked),
            )
            for variable in behaviour.variables:
                values = _values(variable.type, variable.key) if variable.in_state else None
                if values is not None:
                    yield StateVariable(
                        VariableKind.DATA, variable.key, values, values.index(variable.initial)
                    )
        for communication in component.communications:
            if communication.has_phase:
                yield StateVariable(
                    VariableKind.PHASE,
                    communication.key,
                    ("idle", "busy"),
                    _IDLE,
                    frozenset({_IDLE}),
                )


@dataclass(frozen=True)
class _Context:
    robot: Robot
    variables: tuple[StateVariable, ...]
    variable_index: dict[tuple[VariableKind, str], int]
    listeners: dict[tuple[EventKind, str], tuple[Component, ...]]
    """Components that mention an event of a communication, in model order."""

    @classmethod
    def of(cls, robot: Robot) -> _Context:
        variables = tuple(_state_variables(robot))
        listeners: dict[tuple[EventKind, str], dict[str, Component]] = {}
        for component in robot.components:
            if component.behaviour is not None:
                for transition in _result_transitions(component.behaviour):
                    key = transition.event, transition.communication
                    listeners.setdefault(key, {})[component.name] = component
        return cls(
            robot,
            variables,
            {(variable.kind, variable.name): i for i, variable in enumerate(variables)},
            {key: tuple(found.values()) for key, found in listeners.items()},
        )

    def events_of(self, component: Component) -> Iterator[Event]:
        for communication in component.communications:
            for kind in EVENTS_OF[communication.kind]:
                yield self._communication_event(communication, kind)
        if component.behaviour is not None:
            yield from self._tau_events(component, component.behaviour)

    def _communication_event(self, communication: Communication, kind: EventKind) -> Event:
        key = communication.key
        automata = tuple(
            self._automaton(component, kind, key)
            for component in self.listeners.get((kind, key), ())
        )
        phase = None
        if communication.has_phase:
            phase = PhaseStep(self.variable_index[VariableKind.PHASE, key], *_PHASES[kind])
        requirement, indexes = self._requirement(key, kind)
        return Event(
            kind=kind,
            name=self.robot.display_names[key],
            key=key,
            index=0,
            controllable=kind in (EventKind.REQUEST, EventKind.CANCEL),
            parameters=_parameters(automata),
            phase=phase,
            automata=automata,
            requirement=requirement,
            requirements=indexes,
            span=communication.span,
        )

    def _requirement(self, key: str, kind: EventKind) -> tuple[Expr | None, tuple[int, ...]]:
        if kind not in (EventKind.REQUEST, EventKind.CANCEL):
            return None, ()
        found = {i: r for i, r in enumerate(self.robot.requirements) if key in r.communications}
        kept = [r.condition if r.kind == "needs" else negation(r.condition) for r in found.values()]
        if kind is EventKind.CANCEL:
            # Cancelling is for goals that a requirement speaks against now, and for no others.
            return disjunction(negation(condition) for condition in kept), tuple(found)
        requirement = conjunction(kept)
        return (None if requirement == TRUE else requirement), tuple(found)

    def _automaton(self, component: Component, kind: EventKind, key: str) -> LocalAutomaton:
        behaviour = component.behaviour
        assert behaviour is not None
        own = [t for t in behaviour.transitions if t.event is kind and t.communication == key]
        edges: list[Edge] = []
        for location, state in enumerate(behaviour.states):
            local = [t for t in state.transitions if t.event is kind and t.communication == key]
            edges.extend(self._edge(component, location, t) for t in local or own)
        variable = self.variable_index[VariableKind.LOCATION, component.name]
        return LocalAutomaton(component.name, variable, tuple(edges), kind is EventKind.REQUEST)

    def _edge(self, component: Component, location: int, transition: ResultTransition) -> Edge:
        updates: list[tuple[int, Expr]] = []
        data: list[Assignment] = []
        for assignment in transition.assignments:
            variable = self.variable_index.get(
                (VariableKind.DATA, f"{component.name}.{assignment.variable}")
            )
            if variable is None:
                data.append(assignment)
            else:
                updates.append((variable, assignment.value))
        target = self._target(component, location, transition.goto)
        return Edge(
            location, transition.guard, tuple(updates), tuple(data), target, transition.span
        )

    def _target(self, component: Component, location: int, goto: str | None) -> int:
        if goto is None:
            return location
        values = self.variables[self.variable_index[VariableKind.LOCATION, component.name]].values
        return values.index(goto)

    def _tau_events(self, component: Component, behaviour: Behaviour) -> Iterator[Event]:
        everywhere = range(len(behaviour.states))
        taus: list[tuple[Tau, Iterable[int]]] = [(tau, everywhere) for tau in behaviour.taus]
        for location, state in enumerate(behaviour.states):
            taus.extend((tau, (location,)) for tau in state.taus)
        variable = self.variable_index[VariableKind.LOCATION, component.name]
        for tau, locations in sorted(taus, key=lambda item: item[0].index):
            edges = tuple(
                Edge(
                    location,
                    tau.guard,
                    (),
                    (),
                    self._target(component, location, tau.goto),
                    tau.span,
                )
                for location in locations
            )
            yield Event(
                kind=EventKind.TAU,
                name=component.name,
                key=component.name,
                index=tau.index,
                controllable=True,
                parameters=(),
                phase=None,
                automata=(LocalAutomaton(component.name, variable, edges, True),),
                requirement=None,
                requirements=(),
                span=tau.span,
            )


def _result_transitions(behaviour: Behaviour) -> Iterator[ResultTransition]:
    yield from behaviour.transitions
    for state in behaviour.states:
        yield from state.transitions


def _parameters(automata: Iterable[LocalAutomaton]) -> tuple[Parameter, ...]:
    """The parts of the value that guards and synthesis variables take, in order of appearance."""
    found: dict[tuple[str | int, ...], Parameter] = {}
    for automaton in automata:
        for edge in automaton.edges:
            readers = [expr for _, expr in edge.updates]
            if edge.guard is not None:
                readers.append(edge.guard)
            for part in (part for expr in readers for part in walk(expr)):
                if isinstance(part, ValueRef) and part.path not in found:
                    found[part.path] = _parameter(part)
    return tuple(found.values())


def _parameter(reference: ValueRef) -> Parameter:
    values = _values(reference.type, "a value that comes in")
    assert values is not None, "a value of an infinite type takes part in synthesis"
    if any(isinstance(part, int) for part in reference.path):
        return Parameter(reference.path, reference.type, (*values, None))
    return Parameter(reference.path, reference.type, values)


def _values(type_: Type, what: str) -> Sequence[Value] | None:
    values = domain(type_)
    if isinstance(values, range) and values.stop - values.start > _MOST_VALUES:
        raise StateSpaceError(
            f"{what}, {type_}, takes more than {_MOST_VALUES} values:"
            " narrow its range, or convert it by an enum"
        )
    return values
