"""The sources that events and expressions read: state variables, and parameters of events."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import TypeAlias

from robosc.plant.automaton import Plant
from robosc.plant.event_values import values_read
from robosc.plant.support import event_support, step_support, support

LeafSource: TypeAlias = int | tuple[int, int]
"""What a leaf reads: a state variable, or (number of the event, number of its parameter)."""


def touched_together(plant: Plant, items: Sequence[LeafSource]) -> Iterator[list[int]]:
    """Yield groups for the variable order: what one event or condition reads or writes."""
    number = {item: n for n, item in enumerate(items)}
    for e, event in enumerate(plant.events):
        places = {p.path: number[e, n] for n, p in enumerate(event.parameters)}
        if len(places) > 1:  # each parameter close to what is assigned from it
            for edge in (edge for automaton in event.automata for edge in automaton.edges):
                for variable, expr in edge.updates:
                    read = (places[path] for path in values_read([expr]))
                    yield [variable, *support(plant, expr), *read]
        yield [*places.values(), *step_support(plant, event)]
        if event.requirement is not None:
            yield [*places.values(), *event_support(plant, event)]
    for condition, _ in plant.invariants:
        yield [*support(plant, condition)]
