"""A condition on the state after an event, as one on the state before it.

By Dijkstra's weakest precondition, which is exact: the components' transitions say what each event
does.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence, Set
from dataclasses import field
from itertools import product
from typing import TypeAlias

from robosc.expr import tree, types
from robosc.expr.traversal import may_be_undefined, rewritten, walk, with_operands
from robosc.expr.undefined_data import defined, known_condition
from robosc.language.events import EventKind
from robosc.lazy_dataclasses import dataclass
from robosc.model.automata import Assignment, Transition
from robosc.model.entities import Communication, Component, Robot
from robosc.plant.logic import conjunction, disjunction, negation
from robosc.plant.places import each_place, in_states
from robosc.plant.precedence import taken_in

Owner: TypeAlias = str
"""A component by its name, or a communication, whose phase is meant, by its key."""


@dataclass(frozen=True)
class EventCase:
    """What an event does to a component in the states ``here`` (or to a phase) where ``where``
    holds; ``condition`` is both.

    ``place`` is the state or the phase after it; None: as before.
    """

    condition: tree.Expr
    where: tree.Expr = tree.TRUE
    here: Sequence[str] = ()
    place: str | None = None
    assigned: Mapping[str, tree.Expr] = field(default_factory=dict)


def cases_of(
    robot: Robot, communication: Communication, kind: EventKind
) -> Mapping[Owner, Sequence[EventCase]]:
    """What an event of a communication does to all components, and to the communication."""
    components = [c for c in robot.components if c.states]
    cases: dict[Owner, Sequence[EventCase]] = {
        c.name: _cases(robot, c, communication.key, kind) for c in components
    }
    sort = communication.sort.event(kind)
    assert sort is not None
    return cases | {
        communication.key: [EventCase(tree.TRUE, place=communication.phase_after(sort))]
    }


def cases_of_step(
    robot: Robot, component: Component, place: str | None, transition: Transition
) -> dict[Owner, Sequence[EventCase]]:
    """What a transition, which stands in a place and belongs to one component, does where it is
    taken."""
    here = [state.name for state in component.states if state.is_in(place)]
    in_here = _in_states(robot, component, here)
    found = [
        EventCase(
            conjunction([in_here, *where]),
            conjunction(where),
            here,
            transition.goto,
            dict(assigned),
        )
        for where, assigned in _defined(component, transition.assignments)
    ]
    return {component.name: found}


def _cases(robot: Robot, component: Component, key: str, kind: EventKind) -> list[EventCase]:
    """What an event does to a component: exactly one of the cases holds."""
    behaviour = component.behaviour
    states: dict[_Effect, list[str]] = {}
    for state in behaviour.states:
        before: list[tree.Expr] = []
        for taken in taken_in(behaviour, state, kind, key):
            guard = conjunction(map(known_condition, taken.guards))
            place = None if taken.transition.goto == state.name else taken.transition.goto
            for there, assigned in _defined(component, taken.transition.assignments):
                where = conjunction([*before, guard, *there])
                states.setdefault((where, place, assigned), []).append(state.name)
            before.append(negation(guard))
        states.setdefault((conjunction(before), None, ()), []).append(state.name)
    return [
        EventCase(conjunction([in_here, where]), where, here, place, dict(assigned))
        for (where, place, assigned), here in states.items()
        if where != tree.FALSE
        for in_here in [_in_states(robot, component, here)]
    ]


_Effect: TypeAlias = tuple[tree.Expr, str | None, tuple[tuple[str, tree.Expr], ...]]
"""Where something happens, the state after it, and what is assigned."""


def _in_states(robot: Robot, component: Component, names: Sequence[str]) -> tree.Expr:
    if len(names) == len(component.states):
        return tree.TRUE
    return disjunction(in_states(robot, component.name, names))


def _defined(
    component: Component, assignments: Sequence[Assignment]
) -> Iterator[tuple[list[tree.Expr], tuple[tuple[str, tree.Expr], ...]]]:
    """Yield what is assigned where it is defined and, as then nothing is assigned, where not."""
    values = {f"{component.name}.{a.variable}": a.value for a in assignments}
    unsure = {key: defined(value) for key, value in values.items() if may_be_undefined(value)}
    for there in product((True, False), repeat=len(unsure)):
        is_there = dict(zip(unsure, there, strict=True))
        where = [unsure[key] if given else negation(unsure[key]) for key, given in is_there.items()]
        yield where, tuple((key, v) for key, v in values.items() if is_there.get(key, True))


def after_event(condition: tree.Expr, cases: Mapping[Owner, Sequence[EventCase]]) -> tree.Expr:
    """A condition on the state after an event, as one on the state before it."""
    match condition:
        case tree.StateRef(component=name) | tree.PhaseRef(communication=name):
            if all(case.place is None for case in cases.get(name, ())):
                return condition
            # An event may lead from one of several states or phases to another.
            return disjunction(_place_after(part, cases[name]) for part in each_place(condition))
        case tree.Unary() | tree.Binary() if all(
            isinstance(o.type, types.BooleanType) for o in condition.operands
        ):
            return with_operands(
                condition, tuple(after_event(o, cases) for o in condition.operands)
            )
    read = {
        leaf.key: leaf.component for leaf in walk(condition) if isinstance(leaf, tree.VariableRef)
    }
    assigned = {name: _by_assigned(cases.get(name, ()), read.keys()) for name in read.values()}
    changed = [found for found in assigned.values() if any(values for values, _ in found)]
    if not changed:
        return condition
    parts = []
    for together in product(*changed):
        values = {key: value for given, _ in together for key, value in given}

        def leaf(
            node: tree.Literal | tree.Leaf, given: Mapping[str, tree.Expr] = values
        ) -> tree.Expr:
            return given.get(node.key, node) if isinstance(node, tree.VariableRef) else node

        parts.append(conjunction([*(where for _, where in together), rewritten(condition, leaf)]))
    return disjunction(parts)


def _place_after(node: tree.StateRef | tree.PhaseRef, cases: Sequence[EventCase]) -> tree.Expr:
    """Where a component is in a state, or a communication in a phase, after an event."""
    (place,) = node.places
    parts = []
    for case in cases:
        if case.place == place:
            parts.append(case.condition)
        elif case.place is None and place in case.here:
            parts.append(conjunction([case.where, node]))
    return disjunction(parts)


def _by_assigned(
    cases: Sequence[EventCase], variables: Set[str]
) -> list[tuple[tuple[tuple[str, tree.Expr], ...], tree.Expr]]:
    """What a component assigns to these variables, and where."""
    found: dict[tuple[tuple[str, tree.Expr], ...], list[tree.Expr]] = {}
    for case in cases:
        given = tuple((key, value) for key, value in case.assigned.items() if key in variables)
        found.setdefault(given, []).append(case.condition)
    return [(given, disjunction(where)) for given, where in found.items()]
