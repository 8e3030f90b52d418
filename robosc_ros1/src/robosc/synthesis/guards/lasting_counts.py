"""Counts of components that are in a state, or that uncontrollable events may bring into it.

Where ``never count(u.used > 2 for u in User) > 1`` is required, and an uncontrollable event may
increment ``used``, synthesis keeps ``count(u.used >= 2 for u in User) <= 1``: the condition of one
component is extended by the states from which its uncontrollable events lead into it, found by
exploring that component alone. Such counts are candidates for guards; engines check whether one is
exact.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import replace
from itertools import product
from math import prod

from robosc.expr.tree import Binary, Count, Expr
from robosc.plant.automaton import Event, Plant, PlantState
from robosc.plant.counting import counts, tighter
from robosc.plant.step import Verdict, holds, outcome, valuations
from robosc.plant.support import event_support, support
from robosc.synthesis.event_parameters import weight
from robosc.synthesis.explore import reaching
from robosc.synthesis.guards.minimise import condition_on

_MOST_STEPS = 2**10
"""Components with a larger product of states and parameter values are not explored."""


def lasting_counts(plant: Plant, invariant: Expr) -> tuple[Expr, ...]:
    """Return, per count in a state requirement, that one more component may be counted for good.

    Left out where this is the same as one more now (:attr:`Plant.tighter_counts`).
    """

    def find(invariant: Expr) -> tuple[Expr, ...]:
        lasting = (_lasting(plant, count) for count in counts(invariant, plant.robot))
        tight = (tighter(count) for count in lasting if count is not None)
        return tuple(dict.fromkeys(expr for expr in tight if expr is not None))

    return plant.lasting_counts.of(invariant, find)


def _lasting(plant: Plant, count: Count) -> Count | None:
    conditions = []
    for condition in count.conditions:
        lasting = _lasting_condition(plant, condition, count.negated)
        if lasting is None:
            return None
        conditions.append(lasting)
    kept = tuple(conditions)
    return None if kept == count.conditions else replace(count, conditions=kept)


def _lasting_condition(plant: Plant, condition: Expr, may: bool) -> Expr | None:
    """Return that a condition keeps holding (``may``: may come to hold) by uncontrollable events.

    None: too large to explore, or not a condition on one state variable.
    """
    read = support(plant, condition)
    variables, events = _component(plant, read)
    if not events:
        return condition
    order = sorted(variables, key=lambda variable: (variable in read, variable))
    shape = plant.sizes(order)
    if prod(shape) * sum(map(weight, events)) > _MOST_STEPS:
        return None
    states = [_state(plant, order, values) for values in product(*map(range, shape))]
    targets = {state for state in states if holds(plant, condition, state) == may}
    reached = reaching(targets, (step for e in events for step in _steps(plant, e, states)))
    if len(reached) == len(targets):
        return condition
    for variable in reversed(order):
        inside = {state[variable] for state in reached}
        outside = {state[variable] for state in states if state not in reached}
        if outside and inside.isdisjoint(outside):
            lasting = condition_on(plant, variable, inside if may else outside)
            return None if isinstance(lasting, Binary) and lasting.operation.is_lazy else lasting
    return None


def _component(plant: Plant, read: Sequence[int]) -> tuple[set[int], list[Event]]:
    """Return the state variables and uncontrollable events that decide how ``read`` may change.

    It is the closure under: the uncontrollable events that write one of the variables, and the
    variables that those read or write. It is cut short once it is too large to be explored.
    """
    variables = set(read)
    events_of: list[Event] = []
    left = [event for event in plant.events if not event.controllable]
    while True:
        further = [event for event in left if not event.writes.isdisjoint(variables)]
        left = [event for event in left if event.writes.isdisjoint(variables)]
        events_of += further
        variables = variables.union(*(event_support(plant, event) for event in further))
        if not further or prod(plant.sizes(variables)) > _MOST_STEPS:
            return variables, events_of


def _state(plant: Plant, variables: Sequence[int], values: Sequence[int]) -> PlantState:
    state = list(plant.initial)
    for variable, value in zip(variables, values, strict=True):
        state[variable] = value
    return tuple(state)


def _steps(
    plant: Plant, event: Event, states: Sequence[PlantState]
) -> Iterator[tuple[PlantState, PlantState]]:
    for state, values in product(states, valuations(event)):
        after = outcome(plant, event, values, state)
        if not isinstance(after, Verdict):
            yield state, after
