"""A bound on run-to-completion steps from the components' automata alone."""

from __future__ import annotations

from robosc.language.events import EventKind
from robosc.plant.automaton import Plant


def longest_locally(plant: Plant) -> int | None:
    """Return the sum of the components' longest paths of internal transitions, guards ignored.

    It bounds a run-to-completion step if none of them assigns anything and stays in its state.
    None if there is such a one, or if those of a component form a cycle.
    """
    import networkx as nx  # imported on demand: the import takes longer than most syntheses

    graph = nx.DiGraph()
    for event in plant.events:
        if event.kind is EventKind.TAU:
            graph.add_edges_from(
                ((a.component, edge.source), (a.component, edge.target))
                for a in event.automata
                for edge in a.edges
                if edge.source != edge.target or edge.updates
            )
    if not nx.is_directed_acyclic_graph(graph):
        return None
    parts = (graph.subgraph(part) for part in nx.weakly_connected_components(graph))
    longest: int = sum(nx.dag_longest_path_length(part) for part in parts)
    return longest
