"""Lowering: from the model to the plant (docs/semantics.md, "The plant")."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass

from robosc.errors import StateSpaceError
from robosc.ir.automaton import (
    Edge,
    Event,
    EventParameter,
    LocalAutomaton,
    PhaseStep,
    Plant,
    StateVariable,
    VariableKind,
    values_read,
)
from robosc.ir.combining import Taken, result_transitions, taken_in
from robosc.ir.finite.builder import finite_view
from robosc.ir.finite.classes import Classes
from robosc.ir.finite.terms import Term
from robosc.ir.finite.view import FiniteView, may_be_missing, reference_to
from robosc.ir.formulas import Leaf, conjunction, disjunction, negation, to_dsl
from robosc.language.events import EventSort
from robosc.model.entities import (
    After,
    Behaviour,
    Communication,
    Component,
    EventKind,
    ResultTransition,
    Robot,
    Tau,
    Variable,
)
from robosc.model.expr import TRUE, ChoiceRef, Expr, TestRef, ValueRef, VariableRef
from robosc.model.types import Type, Value, domain

__all__ = ["lower"]

_MOST_VALUES = 2**20
"""The largest number of values of a variable or of a part of an event's value."""


def lower(robot: Robot) -> Plant:
    """Return the plant of a model without errors.

    Raises:
        StateSpaceError: a range has too many values.
    """
    context = _Context.of(robot)
    events = tuple(
        event for component in robot.components for event in context.events_of(component)
    )
    invariants = tuple(
        (context.view.met(requirement), index)
        for index, requirement in enumerate(robot.requirements)
        if requirement.kind in ("never", "always")
    )
    return Plant(robot, context.variables, events, invariants, context.view)


def _state_variables(robot: Robot, view: FiniteView) -> Iterator[StateVariable]:
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
                if variable.key in view.variables:
                    yield _classified(variable, view)
                elif variable.in_state and domain(variable.type) is not None:
                    values = _values(variable.type, variable.key)
                    yield StateVariable(
                        VariableKind.DATA, variable.key, values, values.index(variable.initial)
                    )
        for communication in component.communications:
            phases = communication.phases
            if phases is not None:
                marked = frozenset(phases.names.index(name) for name in phases.marked)
                yield StateVariable(VariableKind.PHASE, communication.key, phases.names, 0, marked)
    for test in view.tests:
        classes = view.values(None, test)
        outcomes = _values(test.type, test.name) if classes is None else classes
        labels = None if classes is None else _labels(classes, test, robot)
        starts = view.starts(test, outcomes)
        yield StateVariable(
            VariableKind.TEST, test.name, outcomes, starts[0], None, labels, test, starts
        )


def _classified(variable: Variable, view: FiniteView) -> StateVariable:
    """Return the state variable, with classes as values, of a variable of an unbounded type."""
    classes = view.variables[variable.key]
    return StateVariable(
        VariableKind.DATA,
        variable.key,
        classes,
        classes.index(variable.initial),
        labels=_labels(classes, reference_to(variable), view.robot),
    )


@dataclass(frozen=True)
class _Context:
    robot: Robot
    view: FiniteView
    variables: tuple[StateVariable, ...]
    variable_index: dict[tuple[VariableKind, str], int]
    listeners: dict[tuple[EventKind, str], tuple[Component, ...]]
    """Components that mention an event of a communication, in model order."""

    @classmethod
    def of(cls, robot: Robot) -> _Context:
        view = finite_view(robot)
        variables = tuple(_state_variables(robot, view))
        listeners: dict[tuple[EventKind, str], dict[str, Component]] = {}
        for component in robot.components:
            if component.behaviour is not None:
                for transition in result_transitions(component.behaviour):
                    key = transition.event, transition.communication
                    listeners.setdefault(key, {})[component.name] = component
        return cls(
            robot,
            view,
            variables,
            {(variable.kind, variable.name): i for i, variable in enumerate(variables)},
            {key: tuple(found.values()) for key, found in listeners.items()},
        )

    def events_of(self, component: Component) -> Iterator[Event]:
        for communication in component.communications:
            for sort in communication.sort.events_of(communication.timeout is not None):
                yield self._communication_event(communication, sort)
        if component.behaviour is not None:
            yield from self._tau_events(component, component.behaviour)
            yield from self._after_events(component, component.behaviour)

    def _communication_event(self, communication: Communication, sort: EventSort) -> Event:
        key, kind = communication.key, sort.kind
        automata = tuple(
            self._automaton(component, kind, key)
            for component in self.listeners.get((kind, key), ())
        )
        phase = None
        if communication.phases is not None:
            index = communication.phases.names.index
            phase = PhaseStep(
                self.variable_index[VariableKind.PHASE, key],
                tuple(index(name) for name in sort.sources),
                index(sort.target),
            )
        requirement, indexes = self._requirement(key, kind)
        return Event(
            kind=kind,
            name=self.robot.display_names[key],
            key=key,
            index=0,
            controllable=kind.controllable,
            parameters=tuple(self._parameters(automata, (kind, key))),
            phase=phase,
            automata=automata,
            requirement=requirement,
            requirements=indexes,
            span=communication.span,
        )

    def _requirement(self, key: str, kind: EventKind) -> tuple[Expr | None, tuple[int, ...]]:
        if not kind.controllable:
            return None, ()
        found = {i: r for i, r in enumerate(self.robot.requirements) if key in r.communications}
        kept = [self.view.met(requirement) for requirement in found.values()]
        if kind is EventKind.CANCEL:
            # A goal may be cancelled only while a requirement on its action is violated.
            return disjunction(negation(condition) for condition in kept), tuple(found)
        requirement = conjunction(kept)
        return (None if requirement == TRUE else requirement), tuple(found)

    def _automaton(self, component: Component, kind: EventKind, key: str) -> LocalAutomaton:
        behaviour = component.behaviour
        assert behaviour is not None
        edges = [
            self._edge(component, location, taken)
            for location, state in enumerate(behaviour.states)
            for taken in taken_in(behaviour, state, kind, key)
        ]
        variable = self.variable_index[VariableKind.LOCATION, component.name]
        return LocalAutomaton(component.name, variable, tuple(edges), kind.synchronised)

    def _edge(self, component: Component, location: int, taken: Taken) -> Edge:
        transition = taken.transition
        guards = [self.view.expression(guard) for guard in taken.guards]
        return Edge(
            location,
            conjunction(guards) if guards else None,
            tuple(self._updates(component, transition)),
            transition.assignments,
            self._target(component, location, transition.goto),
            transition.goto is not None,
            taken.level,
            transition.span,
        )

    def _updates(
        self, component: Component, transition: ResultTransition
    ) -> Iterator[tuple[int, Expr]]:
        for assignment in transition.assignments:
            key = f"{component.name}.{assignment.variable}"
            variable = self.variable_index.get((VariableKind.DATA, key))
            if variable is not None and key not in self.view.variables:
                yield variable, self.view.assigned(self.robot.variables[key], assignment.value)
        for term, update in self.view.updates(component.name, transition):
            yield self.variable_index[_index_of(term)], update

    def _target(self, component: Component, location: int, goto: str | None) -> int:
        if goto is None:
            return location
        values = self.variables[self.variable_index[VariableKind.LOCATION, component.name]].values
        return values.index(goto)

    def _parameters(
        self, automata: Iterable[LocalAutomaton], scope: tuple[EventKind, str]
    ) -> Iterator[EventParameter]:
        """Yield the parts of the value that guards and updates read, in order of appearance."""
        read = values_read(expr for automaton in automata for expr in automaton.expressions)
        for part in read.values():
            yield self._parameter(part, scope)

    def _parameter(self, reference: ValueRef, scope: tuple[EventKind, str]) -> EventParameter:
        test = reference.test if isinstance(reference, ChoiceRef) else None
        labels = None
        values: Sequence[Value | None] | None = self.view.values(scope, reference)
        if isinstance(values, Classes):
            labels = _labels(values, reference, self.robot)
        else:
            values = _values(reference.type, "a received value")
            if may_be_missing(reference):
                values = (*values, None)
        optional = reference.optional
        return EventParameter(reference.path, reference.type, values, labels, test, optional)

    def _after_events(self, component: Component, behaviour: Behaviour) -> Iterator[Event]:
        afters = [(a, n) for n, state in enumerate(behaviour.states) for a in state.afters]
        for after, location in sorted(afters, key=lambda item: item[0].index):
            guard = after.transition.guard
            taken = Taken(after.transition, () if guard is None else (guard,), "state")
            edge = self._edge(component, location, taken)
            yield self._event_of(component, EventKind.AFTER, after, (edge,))

    def _tau_events(self, component: Component, behaviour: Behaviour) -> Iterator[Event]:
        everywhere = range(len(behaviour.states))
        taus: list[tuple[Tau, Sequence[int]]] = [(tau, everywhere) for tau in behaviour.taus]
        for location, state in enumerate(behaviour.states):
            taus.extend((tau, (location,)) for tau in state.taus)
        for tau, locations in sorted(taus, key=lambda item: item[0].index):
            edges = tuple(
                Edge(
                    location,
                    None if tau.guard is None else self.view.expression(tau.guard),
                    (),
                    (),
                    self._target(component, location, tau.goto),
                    tau.goto is not None,
                    "state" if len(locations) == 1 else "automaton",
                    tau.span,
                )
                for location in locations
            )
            yield self._event_of(component, EventKind.TAU, tau, edges)

    def _event_of(
        self, component: Component, kind: EventKind, source: After | Tau, edges: tuple[Edge, ...]
    ) -> Event:
        """Return the event of a transition that belongs to one component only."""
        variable = self.variable_index[VariableKind.LOCATION, component.name]
        automaton = LocalAutomaton(component.name, variable, edges, kind.synchronised)
        return Event(
            kind=kind,
            name=component.name,
            key=component.name,
            index=source.index,
            controllable=kind.controllable,
            parameters=tuple(self._parameters((automaton,), (kind, component.name))),
            phase=None,
            automata=(automaton,),
            requirement=None,
            requirements=(),
            span=source.span,
        )


def _index_of(term: VariableRef | TestRef) -> tuple[VariableKind, str]:
    if isinstance(term, TestRef):
        return VariableKind.TEST, term.name
    return VariableKind.DATA, f"{term.component}.{term.variable}"


def _labels(classes: Classes, term: Term, robot: Robot) -> tuple[str, ...]:
    """Return the texts, for users, of the values of a term: ``Battery.charge > 0.2``, ``x <=
    1``."""

    def spelled(leaf: Leaf) -> str | None:
        incoming = isinstance(leaf, ValueRef) and leaf == term
        return to_dsl(leaf, robot).removeprefix("value.") if incoming else None

    return tuple(
        classes.label(number, term, lambda expr: to_dsl(expr, robot, spelled))
        for number in range(len(classes))
    )


def _values(type_: Type, what: str) -> Sequence[Value]:
    """Return the values of a finite type; ``what`` is the subject of error messages."""
    values = domain(type_)
    assert values is not None, f"{what} takes part in synthesis and is not finite"
    if isinstance(values, range) and values.stop - values.start > _MOST_VALUES:
        raise StateSpaceError(
            f"{what}, {type_}, takes more than {_MOST_VALUES} values:"
            " narrow its range, or convert it by an enum"
        )
    return values
