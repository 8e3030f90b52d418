"""Which participants of an event can be dealt with one after another.

A choice of one edge per participant multiplies; beyond some number it is cheaper to let the
participants move in turn. That is exact as long as nobody reads what an earlier one wrote.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from math import prod

from robosc.ir.automaton import Event, Participant, Plant
from robosc.model.expr import Expr, ValueRef, walk
from robosc.synthesis.vectorised import support

__all__ = ["stages_of"]

_MOST_CHOICES = 64


def stages_of(plant: Plant, event: Event) -> list[tuple[Participant, ...]]:
    """The participants in stages, at least one; readers stand before those who write."""
    participants = event.participants
    if prod(_choices(p) for p in participants) <= _MOST_CHOICES:
        return [participants]
    stages: list[tuple[Participant, ...]] = []
    for group in _ordered_groups(plant, participants):
        merged = (*stages[-1], *group) if stages else group
        if stages and prod(_choices(p) for p in merged) <= _MOST_CHOICES:
            stages[-1] = merged
        else:
            stages.append(group)
    return stages


def _choices(participant: Participant) -> int:
    return len({(edge.guard, edge.updates) for edge in participant.edges}) + 1


def _ordered_groups(
    plant: Plant, participants: Sequence[Participant]
) -> list[tuple[Participant, ...]]:
    import networkx as nx  # loaded when it is needed: it costs more than most syntheses

    graph = nx.DiGraph()
    graph.add_nodes_from(range(len(participants)))
    reads = [_reads(plant, p) for p in participants]
    takes = [_takes(p) for p in participants]
    writes = [{p.axis} | {axis for e in p.edges for axis, _ in e.updates} for p in participants]
    for i in range(len(participants)):
        for j in range(len(participants)):
            if i != j and reads[i] & writes[j]:
                graph.add_edge(i, j)
            if i != j and takes[i] & takes[j]:
                graph.add_edges_from([(i, j), (j, i)])
    condensed = nx.condensation(graph)
    order = nx.lexicographical_topological_sort(
        condensed, key=lambda group: min(condensed.nodes[group]["members"])
    )
    return [
        tuple(participants[i] for i in sorted(condensed.nodes[group]["members"])) for group in order
    ]


def _expressions(participant: Participant) -> Iterator[Expr]:
    for edge in participant.edges:
        if edge.guard is not None:
            yield edge.guard
        for _, expr in edge.updates:
            yield expr


def _reads(plant: Plant, participant: Participant) -> set[int]:
    return {axis for expr in _expressions(participant) for axis in support(plant, expr)}


def _takes(participant: Participant) -> set[tuple[str | int, ...]]:
    """The parts of the event's value that the participant reads.

    Those of one array count as the array: which of them did not come hangs together.
    """
    return {
        node.path[: next((d for d, step in enumerate(node.path) if isinstance(step, int)), None)]
        for expr in _expressions(participant)
        for node in walk(expr)
        if isinstance(node, ValueRef)
    }
