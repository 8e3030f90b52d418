"""A bound on run-to-completion steps from the components' automata alone."""

from __future__ import annotations

from collections import defaultdict
from graphlib import CycleError, TopologicalSorter

from robosc.language.events import EventKind
from robosc.plant.automaton import Plant


def longest_locally(plant: Plant) -> int | None:
    """Return the sum of the components' longest paths of internal transitions, guards ignored.

    It bounds a run-to-completion step if none of them assigns anything and stays in its state.
    None if there is such a one, or if those of a component form a cycle.
    """
    before: dict[tuple[str, int], set[tuple[str, int]]] = defaultdict(set)
    for event in plant.events:
        if event.kind is EventKind.TAU:
            for a in event.automata:
                for edge in a.edges:
                    if edge.source != edge.target or edge.updates:
                        before[a.component, edge.target].add((a.component, edge.source))
    lengths: dict[tuple[str, int], int] = {}
    longest: dict[str, int] = {}
    try:
        for place in TopologicalSorter(before).static_order():
            lengths[place] = max((lengths[one] + 1 for one in before.get(place, ())), default=0)
            longest[place[0]] = max(longest.get(place[0], 0), lengths[place])
    except CycleError:
        return None
    return sum(longest.values())
