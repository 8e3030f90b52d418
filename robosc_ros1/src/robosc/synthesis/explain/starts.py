"""The initial state of an explanation: the one closest to the parameters' defaults.

Parameters of the node are unknown at synthesis, so there is an initial state for each of their
values. An explanation mentions a parameter only if its default would not do.
"""

from __future__ import annotations

from robosc.errors import listing
from robosc.ir.automaton import Plant, PlantState
from robosc.ir.formulas import conjunction, to_dsl
from robosc.model.expr import Expr
from robosc.synthesis.minimise import condition_on
from robosc.synthesis.system import System


def assumed(plant: Plant, start: PlantState) -> str:
    """Return which parameters differ from their defaults in an initial state, as a clause."""
    texts = [
        to_dsl(condition_on(plant, number, [index]), plant.robot)
        for number, index in enumerate(start)
        if index != plant.variables[number].initial
    ]
    return f"if {listing(texts)} at the start, " if texts else ""


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
    written = frozenset[int]().union(*(event.writes for event in system.plant.events))
    for number, variable in enumerate(system.plant.variables):
        if found[0][number] == variable.initial or number in written:
            continue
        narrower = conjunction([condition, condition_on(system.plant, number, [variable.initial])])
        path = system.nearest(narrower)
        if path is not None:
            condition, found = narrower, path
    return found
