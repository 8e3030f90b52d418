"""Splitting the automata of an event into stages that are computed one after another.

The number of choices of one edge per automaton is a product; above some number it is cheaper to
apply the automata in turn. That is exact as long as none reads what an earlier one writes.
"""

from __future__ import annotations

from collections.abc import Sequence
from math import prod

from robosc.plant.automaton import Event, LocalAutomaton, Plant
from robosc.plant.event_values import values_read
from robosc.plant.support import support

_MOST_CHOICES = 64
"""Combinations of edges up to which automata are in one stage."""


def stages_of(plant: Plant, event: Event) -> list[tuple[LocalAutomaton, ...]]:
    """Return the automata in stages, at least one; readers of a variable before its writers."""
    automata = event.automata
    if prod(_choices(p) for p in automata) <= _MOST_CHOICES:
        return [automata]
    stages: list[tuple[LocalAutomaton, ...]] = []
    for group in _ordered_groups(plant, automata):
        merged = (*stages[-1], *group) if stages else group
        if stages and prod(_choices(p) for p in merged) <= _MOST_CHOICES:
            stages[-1] = merged
        else:
            stages.append(group)
    return stages


def _choices(automaton: LocalAutomaton) -> int:
    return len({(edge.guard, edge.updates) for edge in automaton.edges}) + 1


def _ordered_groups(
    plant: Plant, automata: Sequence[LocalAutomaton]
) -> list[tuple[LocalAutomaton, ...]]:
    import networkx as nx  # imported on demand: the import takes longer than most syntheses

    graph = nx.DiGraph()
    graph.add_nodes_from(range(len(automata)))
    reads = [_reads(plant, automaton) for automaton in automata]
    takes = [_takes(automaton) for automaton in automata]
    writes = [set(automaton.writes) for automaton in automata]
    for i in range(len(automata)):
        for j in range(len(automata)):
            if i != j and reads[i] & writes[j]:
                graph.add_edge(i, j)
            if i != j and takes[i] & takes[j]:
                graph.add_edges_from([(i, j), (j, i)])
    condensed = nx.condensation(graph)
    order = nx.lexicographical_topological_sort(
        condensed, key=lambda group: min(condensed.nodes[group]["members"])
    )
    return [
        tuple(automata[i] for i in sorted(condensed.nodes[group]["members"])) for group in order
    ]


def _reads(plant: Plant, automaton: LocalAutomaton) -> set[int]:
    return {variable for expr in automaton.expressions for variable in support(plant, expr)}


def _takes(automaton: LocalAutomaton) -> set[tuple[str | int, ...]]:
    """Return the parameters of the event that the automaton reads.

    Elements of one array count as the array, since they are missing together.
    """
    return {
        path[: next((d for d, step in enumerate(path) if isinstance(step, int)), None)]
        for path in values_read(automaton.expressions)
    }
