"""What the robot is assumed not to do, as conditions on the state before an event.

A response or feedback that an assumption excludes is not in the plant. So each event concerned gets
one more automaton: it has one state, and takes the event only where the assumptions allow it. The
engines need no notion of it.

``assume always e`` is about the state after the event. It is brought before the event by Dijkstra's
weakest precondition, which is exact: the components' transitions say what each event does.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence, Set
from dataclasses import dataclass, field
from itertools import product
from typing import TypeAlias

from robosc.expr.presence import defined, known_condition
from robosc.expr.traversal import (
    may_be_undefined,
    reads_value,
    rewritten,
    walk,
    with_operands,
    within,
)
from robosc.expr.tree import (
    FALSE,
    TRUE,
    Binary,
    Expr,
    Leaf,
    Literal,
    PhaseRef,
    StateRef,
    Unary,
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


Restrictions: TypeAlias = Mapping[tuple[EventKind, str], Sequence[Restriction]]
"""By kind and communication, what is assumed of an event; without those of which nothing is."""


@dataclass(frozen=True)
class _Case:
    """What an event does to a component in the states ``here`` (or to a phase) where ``where``
    holds; ``condition`` is both.

    ``place`` is the state or the phase after it; None: as before.
    """

    condition: Expr
    where: Expr = TRUE
    here: Sequence[str] = ()
    place: str | None = None
    assigned: Mapping[str, Expr] = field(default_factory=dict)


def restrictions(robot: Robot) -> Restrictions:
    """Return what is assumed of the events of the robot, without what they always keep to."""
    restricted = {
        (kind, communication.key): tuple(_restrictions_of(robot, communication, kind))
        for communication in robot.communications.values()
        for kind in EXCLUDED
        if communication.sort.event(kind) is not None
    }
    return {event: assumed for event, assumed in restricted.items() if assumed}


def _restrictions_of(
    robot: Robot, communication: Communication, kind: EventKind
) -> Iterator[Restriction]:
    for assumption in robot.assumptions:
        if assumption.communication == communication.key:
            concerned = kind in events_of(assumption, robot)
            condition = known_condition(assumption.condition) if concerned else TRUE
        elif assumption.communication is not None:
            continue
        else:
            condition = _lasting(robot, communication, kind, known_condition(assumption.condition))
        if condition != TRUE:
            yield Restriction(assumption, condition)


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
    components = [c for c in robot.components if c.behaviour is not None]
    cases = {c.name: _cases(c, communication.key, kind) for c in components}
    sort = communication.sort.event(kind)
    assert sort is not None
    phase = {communication.key: [_Case(TRUE, place=communication.phase_after(sort))]}
    after = _after(condition, {**cases, **phase})
    if after == condition or (lasting := simplified(known_condition(after))) == TRUE:
        return TRUE
    # An event that leaves a range leads to no state, so that nothing is assumed of it.
    leaving = (expr for found in cases.values() for case in found for expr in _leaving(case, robot))
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
        _Case(conjunction([_in_states(component, here), where]), where, here, place, dict(assigned))
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


def _after(condition: Expr, cases: Mapping[Owner, Sequence[_Case]]) -> Expr:
    """A condition on the state after an event, as one on the state before it."""
    match condition:
        case StateRef(component=name, state=place) | PhaseRef(communication=name, phase=place):
            return _place_after(condition, place, cases.get(name, ()))
        case Unary() | Binary() if all(isinstance(o.type, BooleanType) for o in condition.operands):
            return with_operands(condition, tuple(_after(o, cases) for o in condition.operands))
    read = {leaf.key: leaf.component for leaf in walk(condition) if isinstance(leaf, VariableRef)}
    assigned = {name: _by_assigned(cases[name], read.keys()) for name in read.values()}
    changed = [found for found in assigned.values() if any(values for values, _ in found)]
    if not changed:
        return condition
    parts = []
    for together in product(*changed):
        values = {key: value for given, _ in together for key, value in given}

        def leaf(node: Literal | Leaf, given: Mapping[str, Expr] = values) -> Expr:
            return given.get(node.key, node) if isinstance(node, VariableRef) else node

        parts.append(conjunction([*(where for _, where in together), rewritten(condition, leaf)]))
    return disjunction(parts)


def _place_after(node: StateRef | PhaseRef, place: str, cases: Sequence[_Case]) -> Expr:
    """Where a component is in a state, or a communication in a phase, after an event."""
    if all(case.place is None for case in cases):
        return node
    parts = []
    for case in cases:
        if case.place == place:
            parts.append(case.condition)
        elif case.place is None and place in case.here:
            parts.append(conjunction([case.where, node]))
    return disjunction(parts)


def _by_assigned(
    cases: Sequence[_Case], variables: Set[str]
) -> list[tuple[tuple[tuple[str, Expr], ...], Expr]]:
    """What a component assigns to these variables, and where."""
    found: dict[tuple[tuple[str, Expr], ...], list[Expr]] = {}
    for case in cases:
        given = tuple((key, value) for key, value in case.assigned.items() if key in variables)
        found.setdefault(given, []).append(case.condition)
    return [(given, disjunction(where)) for given, where in found.items()]


def joined(assumed: Sequence[Restriction]) -> Expr:
    """The condition under which an event keeps to all that is assumed of it."""
    return conjunction(restriction.condition for restriction in assumed)
