"""Conditions that must have held for some time, as components without a text in the model.

Such a component rests until its condition has held for the delay, and then holds. It goes back to
rest by every event after which the condition does not hold; the plant adds that, for it is no
transition of one communication.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace

from robosc.expr.quantified import chain
from robosc.expr.traversal import walk
from robosc.expr.tree import Expr, PhaseRef, StateRef, VariableRef
from robosc.expr.undefined_data import known_condition
from robosc.language.events import EventKind, Kind
from robosc.model.automata import HOLDING, RESTING, Behaviour, Lasting, State, Transition
from robosc.model.entities import Component, Robot


def with_lasting(robot: Robot, found: Sequence[Lasting]) -> Robot:
    """The robot with a component for each of these conditions.

    While a message with a timeout is silent, by whose response a variable is assigned that a
    condition reads, the condition counts as false.
    """
    lasting = tuple(
        replace(one, condition=chain("and", [*_fresh(robot, one), known_condition(one.condition)]))
        for one in _in_order({one.name: one for one in found})
    )
    components = (*robot.components, *map(_component, lasting))
    return replace(robot, components=components, lasting=lasting) if lasting else robot


def _in_order(by_name: Mapping[str, Lasting]) -> Iterator[Lasting]:
    """Yield each condition once, behind those that it reads."""
    met: set[str] = set()

    def visit(name: str) -> Iterator[Lasting]:
        if name in by_name and name not in met:
            met.add(name)
            for leaf in walk(by_name[name].condition):
                if isinstance(leaf, StateRef):
                    yield from visit(leaf.component)
            yield by_name[name]

    for name in by_name:
        yield from visit(name)


def _fresh(robot: Robot, lasting: Lasting) -> Iterator[Expr]:
    read = {leaf.key for leaf in walk(lasting.condition) if isinstance(leaf, VariableRef)}
    assigning = {
        transition.communication
        for component in robot.components
        for transition in component.transitions
        if transition.event is EventKind.RESPONSE
        and any(f"{component.name}.{a.variable}" in read for a in transition.assignments)
    }
    for key, communication in robot.communications.items():
        if key in assigning and communication.kind is Kind.OUTGOING and communication.timeout:
            yield PhaseRef(key, "fresh")


def _component(lasting: Lasting) -> Component:
    name, span = lasting.name, lasting.span
    over = Transition(
        EventKind.AFTER, name, lasting.condition, (), HOLDING, None, 1, lasting.delay, span=span
    )
    states = (
        State(RESTING, True, True, (over,), span=span),
        State(HOLDING, False, True, (), span=span),
    )
    behaviour = Behaviour((), states, (), span=span)
    return Component(name, (), behaviour, None, span=span)
