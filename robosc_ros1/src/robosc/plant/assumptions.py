"""What the robot is assumed not to do, as conditions on the state before an event.

A response or feedback that an assumption excludes is not in the plant. So each event concerned gets
one more automaton: it has one state, and takes the event only where the assumptions allow it. The
engines need no notion of it.

``assume always e`` is about the state after the event. It is brought before the event by Dijkstra's
weakest precondition, which is exact: the components' transitions say what each event does.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence, Set
from dataclasses import dataclass, field
from itertools import product
from typing import TypeAlias

from robosc.expr.presence import defined, known_condition
from robosc.expr.traversal import may_be_undefined, reads_value, rewritten, walk, within
from robosc.expr.tree import (
    FALSE,
    TRUE,
    Binary,
    Expr,
    Leaf,
    Literal,
    PhaseRef,
    StateRef,
    VariableRef,
)
from robosc.expr.types import BooleanType, IntegerType
from robosc.language.events import EventKind
from robosc.model.automata import Assignment
from robosc.model.entities import Assumption, Communication, Component, Robot
from robosc.plant.formulas import conjunction, disjunction, negation, simplified
from robosc.plant.precedence import taken_in

EXCLUDED = (EventKind.RESPONSE, EventKind.FEEDBACK)
"""The events that are assumed away; those of time, of failures and of calls never are."""

Owner: TypeAlias = str
"""A component by its name, or a communication, whose phase is meant, by its key."""


@dataclass(frozen=True)
class Restriction:
    """An assumption, as the condition before an event under which the event keeps to it."""

    assumption: Assumption
    condition: Expr


@dataclass(frozen=True)
class _Case:
    """What an event does to a component, or to a phase, where ``condition`` holds.

    ``place`` is the state or the phase after it; None: as before.
    """

    condition: Expr
    place: str | None = None
    assigned: dict[str, Expr] = field(default_factory=dict)

    @property
    def changes(self) -> bool:
        return self.place is not None or bool(self.assigned)

    def seen(self, place: bool, variables: Set[str]) -> _Case:
        """The case as what reads these variables sees it, and the ``place`` if it reads that."""
        assigned = {key: value for key, value in self.assigned.items() if key in variables}
        return _Case(self.condition, self.place if place else None, assigned)


def restrictions(robot: Robot, communication: Communication, kind: EventKind) -> list[Restriction]:
    """Return what is assumed of an event of the robot, without what it always keeps to."""
    found = []
    for assumption in robot.assumptions if kind in EXCLUDED else ():
        if assumption.communication == communication.key:
            concerned = kind in events_of(assumption, robot)
            condition = known_condition(assumption.condition) if concerned else TRUE
        elif assumption.communication is not None:
            continue
        else:
            condition = _lasting(robot, communication, kind, known_condition(assumption.condition))
        if condition != TRUE:
            found.append(Restriction(assumption, condition))
    return found


def events_of(assumption: Assumption, robot: Robot) -> tuple[EventKind, ...]:
    """The events that an assumption is about: those of all communications, or of one.

    One that reads ``value`` is about the response, and about feedback of the same type.
    """
    if assumption.communication is None:
        return EXCLUDED
    communication = robot.communications[assumption.communication]
    alike = communication.response == communication.feedback
    every = alike or not reads_value(assumption.condition)
    found = EXCLUDED if every else (EventKind.RESPONSE,)
    return tuple(kind for kind in found if communication.sort.event(kind) is not None)


def _lasting(robot: Robot, communication: Communication, kind: EventKind, condition: Expr) -> Expr:
    """The condition before an event under which a condition still holds after it, if it did."""
    leaves = list(walk(condition))
    read = {owner for leaf in leaves if (owner := _owner(leaf)) is not None}
    places = {leaf.component for leaf in leaves if isinstance(leaf, StateRef)}
    variables = {leaf.key for leaf in leaves if isinstance(leaf, VariableRef)}
    components = [c for c in robot.components if c.behaviour is not None]
    every = {c.name: _cases(c, communication.key, kind) for c in components}
    effects = [
        (owner, [case.seen(owner in places, variables) for case in cases])
        for owner, cases in every.items()
        if owner in read
    ]
    if communication.key in read:
        sort = communication.sort.event(kind)
        assert sort is not None
        effects.append((communication.key, [_Case(TRUE, sort.target)]))
    effects = [(owner, cases) for owner, cases in effects if any(c.changes for c in cases)]
    parts = []
    for together in product(*(cases for _, cases in effects)):
        if any(case.changes for case in together):
            taken = {o: case for (o, _), case in zip(effects, together, strict=True)}
            after = simplified(known_condition(_after(condition, taken)))
            before = [negation(case.condition) for case in together if case.condition != TRUE]
            parts.append(disjunction([*before, after]))
    lasting = conjunction(part for part in parts if part != TRUE)
    if lasting == TRUE:
        return TRUE
    # An event that leaves a range leads to no state, so that nothing is assumed of it.
    leaving = (expr for cases in every.values() for case in cases for expr in _leaving(case, robot))
    return disjunction([negation(condition), lasting, *leaving])


def _leaving(case: _Case, robot: Robot) -> Iterator[Expr]:
    """Yield when a variable leaves its range."""
    for key, value in case.assigned.items():
        variable = robot.variables[key]
        type_ = variable.type
        if variable.in_state and isinstance(type_, IntegerType) and not within(value, type_):
            assert type_.bounds is not None
            sides = zip(("<", ">"), type_.bounds, strict=True)
            outside = [Binary(op, value, Literal(b, value.type), BooleanType()) for op, b in sides]
            yield conjunction([case.condition, disjunction(outside)])


def _owner(leaf: Expr) -> Owner | None:
    match leaf:
        case StateRef(component=name) | VariableRef(component=name):
            return name
        case PhaseRef(communication=key):
            return key
    return None


def _cases(component: Component, key: str, kind: EventKind) -> list[_Case]:
    """What an event does to a component: exactly one of the cases holds."""
    behaviour = component.behaviour
    assert behaviour is not None
    states: dict[_Effect, list[str]] = {}
    for state in behaviour.states:
        before: list[Expr] = []
        for taken in taken_in(behaviour, state, kind, key):
            guard = conjunction(map(known_condition, taken.guards))
            place = None if taken.transition.goto == state.name else taken.transition.goto
            for there, assigned in _defined(component, taken.transition.assignments):
                where = conjunction([*before, guard, *there])
                states.setdefault((where, place, assigned), []).append(state.name)
            before.append(negation(guard))
        states.setdefault((conjunction(before), None, ()), []).append(state.name)
    return [
        _Case(conjunction([_in_states(component, here), where]), place, dict(assigned))
        for (where, place, assigned), here in states.items()
        if where != FALSE
    ]


_Effect: TypeAlias = tuple[Expr, str | None, tuple[tuple[str, Expr], ...]]
"""Where something happens, the state after it, and what is assigned."""


def _in_states(component: Component, names: Sequence[str]) -> Expr:
    if len(names) == len(component.states):
        return TRUE
    return disjunction(StateRef(component.name, name) for name in names)


def _defined(
    component: Component, assignments: Sequence[Assignment]
) -> Iterator[tuple[list[Expr], tuple[tuple[str, Expr], ...]]]:
    """Yield what is assigned where it is defined and, as then nothing is assigned, where not."""
    values = {f"{component.name}.{a.variable}": a.value for a in assignments}
    unsure = {key: defined(value) for key, value in values.items() if may_be_undefined(value)}
    for there in product((True, False), repeat=len(unsure)):
        is_there = dict(zip(unsure, there, strict=True))
        where = [unsure[key] if given else negation(unsure[key]) for key, given in is_there.items()]
        yield where, tuple((key, v) for key, v in values.items() if is_there.get(key, True))


def _after(condition: Expr, taken: dict[Owner, _Case]) -> Expr:
    """A condition on the state after an event, as one on the state before it."""

    def leaf(node: Literal | Leaf) -> Expr:
        match node:
            case StateRef(component=name, state=place) | PhaseRef(communication=name, phase=place):
                case = taken.get(name)
                if case is not None and case.place is not None:
                    return TRUE if case.place == place else FALSE
            case VariableRef(component=name, key=key) if name in taken:
                value = taken[name].assigned.get(key)
                return node if value is None else value
        return node

    return rewritten(condition, leaf)


def conditions(robot: Robot) -> Iterator[tuple[tuple[EventKind, str], Expr]]:
    """Yield all restrictions, each with the event whose ``value`` it may read."""
    if robot.assumptions:
        for communication in robot.communications.values():
            for kind in EXCLUDED:
                if communication.sort.event(kind) is not None:
                    for restriction in restrictions(robot, communication, kind):
                        yield (kind, communication.key), restriction.condition


def joined(found: Sequence[Restriction]) -> Expr:
    """The condition under which an event keeps to all that is assumed of it."""
    return conjunction(restriction.condition for restriction in found)
