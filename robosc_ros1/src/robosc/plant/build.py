"""Lowering: from the model to the plant (docs/semantics.md, "The plant")."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from dataclasses import replace
from itertools import chain
from typing import NamedTuple

from robosc import errors, limits
from robosc.expr import traversal, tree, types
from robosc.expr.undefined_data import known_condition
from robosc.language.events import EventKind, EventSort, command_key
from robosc.model.automata import HOLDING, RESTING, Behaviour, Transition, is_in
from robosc.model.entities import Communication, Component, Goal, Robot
from robosc.plant import event_values, logic, precedence
from robosc.plant.acceptance import acceptance, is_left_to_components
from robosc.plant.answers import divided_phase
from robosc.plant.assumptions import Restrictions, conditions_of_states, joined, restrictions
from robosc.plant.automaton import (
    ASSUMPTIONS,
    Edge,
    Event,
    EventParameter,
    LocalAutomaton,
    PhaseStep,
    Plant,
    PlantGoal,
    StateVariable,
    VariableKind,
)
from robosc.plant.data import asked_cases, builder, classes, terms
from robosc.plant.data.classes import Classes
from robosc.plant.data.view import FiniteView, Scope, may_be_missing, reference_to
from robosc.plant.lasting import Reset, resets
from robosc.plant.model_text import to_dsl
from robosc.runtime.core.places import place_of

# The values of the terms of a plant, and what users see of them.


def _labels(classes: Classes, term: terms.Term, robot: Robot, whole: bool) -> tuple[str, ...]:
    """Return the texts, for users, of the values of a term: ``Battery.charge > 0.2``, ``x <= 1``,
    with ``whole`` also for a part of a message ``value.x <= 1``."""
    if isinstance(term, tree.ChoiceRef) and term.renews is not None:
        return tuple(f"new {label}" for label in _labels(classes, term.renews, robot, whole))

    def spelled(leaf: tree.Leaf) -> str | None:
        incoming = isinstance(leaf, tree.ValueRef) and leaf == term and not whole
        return to_dsl(leaf, robot).removeprefix("value.") if incoming else None

    return tuple(
        classes.label(number, term, lambda expr: to_dsl(expr, robot, spelled))
        for number in range(len(classes))
    )


def values_of_term(
    view: FiniteView, scope: Scope, term: terms.Term, what: str
) -> tuple[Sequence[types.Value], tuple[str, ...] | None]:
    """Return the values or classes of a term, and the texts of classes for users.

    ``what`` is the subject of error messages.
    """
    classes = view.values(scope, term)
    if classes is not None:
        whole = scope is not None and scope[0] is EventKind.REQUEST
        return classes, _labels(classes, term, view.robot, whole)
    values = types.domain(term.type)
    assert values is not None, f"{what} takes part in synthesis and is not finite"
    if isinstance(values, range) and values.stop - values.start > limits.VALUES:
        raise errors.StateSpaceError(
            f"{what}, {term.type}, takes more than {limits.VALUES} values:"
            " narrow its range, or convert it by an enum"
        )
    return values, None


# Transitions that belong to one component only: internal ones, and those after a delay.


class OwnTransition(NamedTuple):
    """A transition, the locations that it leaves, and where it leads as people read it.

    ``path`` is ``idle->busy``, with the line if another one of its kind leads there as well.
    """

    transition: Transition
    locations: list[int]
    path: str


def own_transitions(behaviour: Behaviour) -> Iterator[OwnTransition]:
    """The internal transitions, then those after a delay, in the order of the model."""
    for kind in (EventKind.TAU, EventKind.AFTER):
        placed = (item for item in behaviour.placed if item[1].event is kind)
        found = sorted(placed, key=lambda item: item[1].index)
        paths = [_path(place, transition) for place, transition in found]
        for (place, transition), path in zip(found, paths, strict=True):
            told = path if paths.count(path) == 1 else f"{path} (line {transition.span.line})"
            inside = [n for n, state in enumerate(behaviour.states) if state.is_in(place)]
            yield OwnTransition(transition, inside, told)


def _path(place: str | None, transition: Transition) -> str:
    """From the state in which it stands (None: from every one) to its target."""
    begin = "every state" if place is None else place
    return "->".join(map(place_of, (begin, transition.goto or begin)))


def lower(robot: Robot) -> Plant:
    """Return the plant of a model without errors.

    Raises:
        StateSpaceError: a range has too many values.
    """
    lowering = _Lowering(robot)
    events = chain.from_iterable(map(lowering.events_of, robot.components))
    invariants = tuple(
        (lowering.view.met(requirement), index)
        for index, requirement in enumerate(robot.requirements)
        if requirement.kind in ("never", "always")
    )
    goals = (_goal(goal, lowering.view, n) for n, goal in enumerate(robot.goals))
    lasting = (
        (lowering.view.expression(condition), index)
        for condition, index in conditions_of_states(robot)
    )
    plant = lowering.variables, tuple(events), invariants, lowering.view, tuple(goals)
    return Plant(robot, *plant, tuple(lasting), lowering.restrictions)


def _goal(goal: Goal, view: FiniteView, index: int) -> PlantGoal:
    origin, along = (
        tree.TRUE if e is None else view.expression(e) for e in (goal.origin, goal.along)
    )
    return PlantGoal(view.expression(goal.condition), origin, along, index)


def _state_variables(
    robot: Robot, view: FiniteView, restrictions: Restrictions
) -> Iterator[StateVariable]:
    for component in robot.components:
        behaviour = component.behaviour
        if behaviour.states:
            states = behaviour.states
            yield StateVariable(
                VariableKind.LOCATION,
                component.name,
                tuple(s.name for s in states),
                next(i for i, s in enumerate(states) if s.initial),
                frozenset(i for i, s in enumerate(states) if s.marked),
            )
            for variable in behaviour.variables:
                is_finite = variable.in_state and types.domain(variable.type) is not None
                if is_finite or variable.key in view.variables:
                    values, labels = values_of_term(
                        view, None, reference_to(variable), variable.key
                    )
                    initial = values.index(variable.initial)
                    found = StateVariable(
                        VariableKind.DATA, variable.key, values, initial, labels=labels
                    )
                    if variable.persistent:
                        others = (n for n in range(len(values)) if n != initial)
                        found = replace(found, starts=(initial, *others))
                    yield found
        for communication in component.communications:
            phases = communication.phases
            if phases is not None:
                marked = frozenset(phases.names.index(name) for name in phases.marked)
                yield StateVariable(VariableKind.PHASE, communication.key, phases.names, 0, marked)
    for test in view.tests:
        outcomes, labels = values_of_term(view, None, test, test.name)
        starts = view.starts(test, outcomes)
        yield StateVariable(
            VariableKind.TEST, test.name, outcomes, starts[0], None, labels, test, starts
        )
    for kind, key in restrictions:
        yield StateVariable(VariableKind.ASSUMPTION, f"{kind.word} from {key}", (True,), 0)


class _Lowering:
    def __init__(self, robot: Robot) -> None:
        self.robot = robot
        self.restrictions = restrictions(robot)
        self.view = builder.finite_view(robot, self.restrictions)
        self.variables = tuple(_state_variables(robot, self.view, self.restrictions))
        self.variable_index = {(v.kind, v.name): i for i, v in enumerate(self.variables)}
        self.provided = {provide.communication for provide in robot.provides}
        self.resets: dict[tuple[EventKind, str, int], list[Reset]] = {}
        """What an event may set back, by its identity."""
        for identity, reset in resets(robot):
            self.resets.setdefault(identity, []).append(reset)
        self.listeners: dict[tuple[EventKind, str], dict[str, Component]] = {}
        """Components that mention an event of a communication, by name, in model order."""
        for component in robot.components:
            for transition in precedence.joined_transitions(component.behaviour):
                key = transition.event, transition.communication
                self.listeners.setdefault(key, {})[component.name] = component

    def events_of(self, component: Component) -> Iterator[Event]:
        for communication in component.communications:
            for sort in communication.sort.events_of(communication.timeout is not None):
                if self._is_left_out(sort.kind, communication.key):
                    continue
                yield from asked_cases.by_data(self._communication_event(communication, sort))
        own = own_transitions(component.behaviour)
        yield from (self._event_of(component, transition) for transition in own)

    def _is_left_out(self, kind: EventKind, key: str) -> bool:
        """Whether nobody makes an event happen."""
        is_left = is_left_to_components(kind, self.robot.communications[key].kind)
        provided = kind is EventKind.PROGRESS and command_key(key, kind) in self.provided
        return is_left and not provided and (kind, key) not in self.listeners

    def _communication_event(self, communication: Communication, sort: EventSort) -> Event:
        key, kind = communication.key, sort.kind
        taking = tuple(
            self._automaton(component, kind, key)
            for component in self.listeners.get((kind, key), {}).values()
        )
        phase = None
        if communication.phases is not None:
            names = communication.phases.names
            index = names.index
            replaces = kind is EventKind.REQUEST and communication.goals is not None
            sources = (*sort.sources, "busy") if replaces else sort.sources
            phase = PhaseStep(
                self.variable_index[VariableKind.PHASE, key],
                tuple(index(name) for name in sources if name in names),
                index(communication.phase_after(sort)),
            )
        automata = (*taking, *self._resets(kind, key), *self._assumptions(key, kind))
        if kind is EventKind.CALL and phase is not None:
            accepts = acceptance(key, phase, taking, self.variables, communication.span)
            automata, phase = (*automata, accepts), None
        assumed = VariableKind.ASSUMPTION, f"{EventKind.RESPONSE.word} from {key}"
        is_assumed = assumed in self.variable_index
        if divided := divided_phase(communication, kind, phase, automata, self.view, is_assumed):
            automata, phase = (*automata, divided), None
        requirement, indexes = self._requirement(key, kind)
        return Event(
            kind=kind,
            name=self.robot.display_names[key],
            key=key,
            index=0,
            controllable=kind.controllable,
            parameters=tuple(self._parameters(automata, (kind, key), requirement)),
            phase=phase,
            automata=automata,
            requirement=requirement,
            requirements=indexes,
            span=communication.span,
        )

    def _assumptions(self, key: str, kind: EventKind) -> Iterator[LocalAutomaton]:
        """The automaton that takes an event only where the robot is assumed to make it happen."""
        assumed = self.restrictions.get((kind, key))
        if assumed:
            name = f"{kind.word} from {key}"
            variable = self.variable_index[VariableKind.ASSUMPTION, name]
            guard = self.view.expression(joined(assumed))
            edge = Edge(0, guard, (), (), 0, False, (), (), assumed[0].assumption.span)
            yield LocalAutomaton(ASSUMPTIONS, variable, (edge,), True)

    def _resets(self, kind: EventKind, key: str, index: int = 0) -> Iterator[LocalAutomaton]:
        """The automata of lasting conditions that an event may set back."""
        for reset in self.resets.get((kind, key, index), ()):
            variable = self.variable_index[VariableKind.LOCATION, reset.lasting.name]
            places = self.variables[variable].values
            guard = self.view.expression(logic.negation(reset.kept))
            ends = places.index(HOLDING), places.index(RESTING)
            edge = Edge(ends[0], guard, (), (), ends[1], True, (), (), reset.lasting.span)
            edges = () if guard == tree.FALSE else (edge,)
            yield LocalAutomaton(reset.lasting.name, variable, edges, False, resets=True)

    def _requirement(self, key: str, kind: EventKind) -> tuple[tree.Expr | None, tuple[int, ...]]:
        if not kind.controllable:
            return None, ()
        found = {
            i: r
            for i, r in enumerate(self.robot.requirements)
            if command_key(key, kind) in r.communications and r.concerns(kind)
        }
        kept = [self.view.met(requirement) for requirement in found.values()]
        if kind is EventKind.CANCEL:
            # A goal may be cancelled only while a requirement on its action is violated.
            return logic.disjunction(_operands("or", map(logic.negation, kept))), tuple(found)
        requirement = logic.conjunction(_operands("and", kept))
        return (None if requirement == tree.TRUE else requirement), tuple(found)

    def _automaton(self, component: Component, kind: EventKind, key: str) -> LocalAutomaton:
        behaviour = component.behaviour
        edges = [
            self._edge(component, location, taken)
            for location, state in enumerate(behaviour.states)
            for taken in precedence.taken_in(behaviour, state, kind, key)
        ]
        variable = self.variable_index[VariableKind.LOCATION, component.name]
        # One of several that perform a command does not block it: a requirement says where it is.
        blocking = kind.synchronised and component.name not in self.robot.together.get(
            command_key(key, kind), ()
        )
        return LocalAutomaton(component.name, variable, tuple(edges), blocking)

    def _edge(self, component: Component, location: int, taken: precedence.Taken) -> Edge:
        transition = taken.transition
        guards = [self.view.expression(guard) for guard in taken.guards]
        updates = tuple(self._updates(component, transition))
        target = self._target(component, location, transition.goto)
        if updates and target == location and transition.event is EventKind.TAU:
            guards.append(self._changes_something(updates))
        return Edge(
            location,
            logic.conjunction(guards) if guards else None,
            updates,
            transition.assignments,
            target,
            transition.goto is not None,
            tuple(_outer(component, location, transition)),
            taken.levels,
            transition.span,
        )

    def _changes_something(self, updates: Iterable[tuple[int, tree.Expr]]) -> tree.Expr:
        """Return the condition that an internal transition, which stays, changes a variable.

        One that changes nothing would be taken without end.
        """
        return logic.disjunction(
            known_condition(tree.Binary("!=", reference_to(variable), value, types.BooleanType()))
            for index, value in updates
            if (variable := self.robot.variables.get(self.variables[index].name)) is not None
        )

    def _updates(
        self, component: Component, transition: Transition
    ) -> Iterator[tuple[int, tree.Expr]]:
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
        self,
        automata: Iterable[LocalAutomaton],
        scope: tuple[EventKind, str],
        requirement: tree.Expr | None = None,
    ) -> Iterator[EventParameter]:
        """Yield the parts of the value that are read, by a requirement on data first."""
        required = () if requirement is None else (requirement,)
        local = (expr for automaton in automata for expr in automaton.expressions)
        read = event_values.values_read(chain(required, local))
        for part in read.values():
            yield self._parameter(part, scope)

    def _parameter(self, reference: tree.ValueRef, scope: tuple[EventKind, str]) -> EventParameter:
        test = reference.test if isinstance(reference, tree.ChoiceRef) else None
        values: Sequence[types.Value | None]
        values, labels = values_of_term(self.view, scope, reference, "a received value")
        if not isinstance(values, classes.Classes) and may_be_missing(reference):
            values = (*values, None)
        optional = reference.optional
        renews = isinstance(reference, tree.ChoiceRef) and test is None
        return EventParameter(
            reference.path, reference.type, values, labels, test, optional, renews
        )

    def _event_of(self, component: Component, own: OwnTransition) -> Event:
        """Return the event of a transition that belongs to one component only."""
        transition, locations, path = own
        kind = transition.event
        guards = () if transition.guard is None else (transition.guard,)
        taken = precedence.Taken(transition, guards, ())
        edges = tuple(self._edge(component, location, taken) for location in locations)
        variable = self.variable_index[VariableKind.LOCATION, component.name]
        automata = (
            LocalAutomaton(component.name, variable, edges, kind.synchronised),
            *self._resets(kind, component.name, transition.index),
        )
        parameters = tuple(self._parameters(automata, (kind, component.name)))
        if parameters and kind is EventKind.TAU:
            where = f"{transition.span.source.path}:{transition.span.line}"
            raise errors.StateSpaceError(
                f"{where}: the outcome of this internal transition is open, for a comparison of"
                " data reads what it assigns: assign that where a message or an answer comes"
                " (on response …), a constant here, or use 'after'"
            )
        return Event(
            kind=kind,
            name=component.name,
            key=component.name,
            index=transition.index,
            controllable=kind.controllable,
            parameters=parameters,
            phase=None,
            automata=automata,
            requirement=None,
            requirements=(),
            path=path,
            span=transition.span,
        )


def _outer(component: Component, location: int, taken: Transition) -> Iterator[str]:
    """The states with states in them, and with transitions after a delay, that one enters or
    leaves."""
    behaviour = component.behaviour
    source = behaviour.states[location]
    for outer in behaviour.composites:
        if outer.afters and taken.goto is not None:
            leaves = source.is_in(outer.name) and not is_in(taken.goto, outer.name)
            if leaves or taken.enters(outer.name, source):
                yield outer.name


def _index_of(term: tree.VariableRef | tree.TestRef) -> tuple[VariableKind, str]:
    if isinstance(term, tree.TestRef):
        return VariableKind.TEST, term.name
    return VariableKind.DATA, f"{term.component}.{term.variable}"


def _operands(operator: str, conditions: Iterable[tree.Expr]) -> Iterator[tree.Expr]:
    """What conditions join: requirements may share some of it."""
    return chain.from_iterable(traversal.operands(condition, operator) for condition in conditions)
