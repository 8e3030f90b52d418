"""How an explanation begins: in the initial state closest to the parameters' defaults.

Parameters of the node, and what persistent variables have kept, are unknown at synthesis, so there
is an initial state for each of their values. An explanation mentions a parameter only if its
default would not do. One without a trace begins in some state, of which it tells what concerns its
condition.
"""

from __future__ import annotations

from robosc import limits
from robosc.errors import listing
from robosc.expr.tree import TRUE, Expr
from robosc.plant.automaton import Plant, PlantState
from robosc.plant.logic import conjunction
from robosc.plant.model_text import to_dsl
from robosc.plant.support import support
from robosc.synthesis.controlled_system import System
from robosc.synthesis.guards.minimise import condition_on

UNTRACED = "(no trace to such a state was looked for: that would take too long)"
"""What an explanation ends in that begins in some state."""


def assumed(plant: Plant, start: PlantState) -> str:
    """Return what differs from the defaults of the model in an initial state, as a clause."""
    texts = [
        to_dsl(condition_on(plant, number, [index]), plant.robot)
        for number, index in enumerate(start)
        if index != plant.variables[number].initial
    ]
    return f"if {listing(texts)} at the start, " if texts else ""


def whereabouts(plant: Plant, state: PlantState, condition: Expr) -> str:
    """Return what is the case in a state with a condition, as a clause: ``where A.b and C.d = 1``.

    Of the state variables, those are told that the condition reads, and parameters that are not at
    their defaults.
    """
    read = support(plant, condition)
    told = [
        condition_on(plant, number, [index])
        for number, index in enumerate(state)
        if number in read or (index != plant.variables[number].initial and _is_fixed(plant, number))
    ]
    texts = [to_dsl(condition, plant.robot) for condition in told if condition != TRUE]
    if len(texts) > limits.TOLD_VARIABLES:
        texts[limits.TOLD_VARIABLES - 1 :] = [
            f"{len(texts) - limits.TOLD_VARIABLES + 1} other conditions hold"
        ]
    return f"where {listing(texts)}" if texts else "in some state"


def _is_fixed(plant: Plant, number: int) -> bool:
    """Whether no event writes a state variable, as those of parameters."""
    return all(number not in event.writes for event in plant.events)


def lost_start(system: System) -> PlantState:
    """Return an initial state that is not good; there is one."""
    state = system.lost_start()
    for number, variable in enumerate(system.plant.variables):
        other = (*state[:number], variable.initial, *state[number + 1 :])
        if not system.is_good(other):
            state = other
    return state


def nearest(system: System, condition: Expr) -> tuple[PlantState, ...] | None:
    """Return :meth:`System.nearest`, with as many parameters as possible at their defaults."""
    found = system.nearest(condition)
    if found is None:
        return None
    for number, variable in enumerate(system.plant.variables):
        if found[0][number] == variable.initial or not _is_fixed(system.plant, number):
            continue
        narrower = conjunction([condition, condition_on(system.plant, number, [variable.initial])])
        path = system.nearest(narrower)
        if path is not None:
            condition, found = narrower, path
    return found
