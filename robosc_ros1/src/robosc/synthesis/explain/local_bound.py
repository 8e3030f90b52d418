"""A bound on completions from the components' automata alone."""

from __future__ import annotations

from robosc.ir.automaton import Plant
from robosc.model.entities import EventKind

__all__ = ["longest_locally"]


def longest_locally(plant: Plant) -> int | None:
    """A bound on completions: internal transitions change nothing but locations.

    None if those of some component form a cycle, their guards left aside.
    """
    import networkx as nx  # loaded when it is needed: it costs more than most syntheses

    graph = nx.DiGraph()
    for event in plant.events:
        if event.kind is EventKind.TAU:
            graph.add_edges_from(
                ((a.component, edge.source), (a.component, edge.target))
                for a in event.automata
                for edge in a.edges
                if edge.source != edge.target
            )
    if not nx.is_directed_acyclic_graph(graph):
        return None
    parts = (graph.subgraph(part) for part in nx.weakly_connected_components(graph))
    longest: int = sum(nx.dag_longest_path_length(part) for part in parts)
    return longest
