"""Which state variables expressions and events depend on."""

from __future__ import annotations

from robosc.expr import traversal, tree
from robosc.plant.automaton import Event, Plant


def support(plant: Plant, expr: tree.Expr) -> tuple[int, ...]:
    """Return the state variables that an expression reads, ascending."""

    def find(expr: tree.Expr) -> tuple[int, ...]:
        read = (plant.variable_of(node) for node in traversal.walk_all([expr]))
        return tuple(sorted({variable for variable in read if variable is not None}))

    return plant.supports.of(expr, find)


def step_support(plant: Plant, event: Event) -> set[int]:
    """Return the state variables that an event in the plant reads or writes."""
    found = set() if event.phase is None else {event.phase.variable}
    for automaton in event.automata:
        found.add(automaton.variable)
        found.update(automaton.writes, *(support(plant, expr) for expr in automaton.expressions))
    return found


def event_support(plant: Plant, event: Event) -> set[int]:
    """Return the same with what the event's requirement reads."""
    required = () if event.requirement is None else support(plant, event.requirement)
    return step_support(plant, event).union(required)
