"""The sources that events and expressions read: state variables, and parameters of events."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import TypeAlias

from robosc.ir.automaton import Plant
from robosc.model.expr import Expr, Leaf
from robosc.model.traversal import walk
from robosc.synthesis.event_parameters import values_read
from robosc.synthesis.vectorised import support

__all__ = ["LeafSource", "leaves", "touched_together"]

LeafSource: TypeAlias = int | tuple[int, int]
"""What a leaf reads: a state variable, or (number of the event, number of its parameter)."""


def leaves(expr: Expr) -> Iterator[Leaf]:
    for node in walk(expr):
        if isinstance(node, Leaf):
            yield node


def touched_together(plant: Plant, items: Sequence[LeafSource]) -> Iterator[list[int]]:
    """Yield groups for the variable order: what one event or condition reads or writes."""
    number = {item: n for n, item in enumerate(items)}
    for e, event in enumerate(plant.events):
        group = [number[e, p] for p in range(len(event.parameters))]
        if event.phase is not None:
            group.append(event.phase.variable)
        for automaton in event.automata:
            group.append(automaton.variable)
            for edge in automaton.edges:
                if edge.guard is not None:
                    group.extend(support(plant, edge.guard))
                for variable, expr in edge.updates:
                    group.extend((variable, *support(plant, expr)))
                    if len(event.parameters) > 1:  # each beside what is assigned from it
                        taken = values_read([expr])
                        own = [p for p, one in enumerate(event.parameters) if one.path in taken]
                        places = (number[e, p] for p in own)
                        yield [variable, *support(plant, expr), *places]
        yield group
        if event.requirement is not None:
            yield [*group, *support(plant, event.requirement)]
    for condition, _ in plant.invariants:
        yield [*support(plant, condition)]
