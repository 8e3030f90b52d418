"""The longest chain of internal transitions of each component, against networkx."""

from __future__ import annotations

import networkx as nx
from hypothesis import given
from hypothesis import strategies as st
from synthesis.plants import plant_of

from robosc.synthesis.explain.local_bound import longest_locally

STATES = range(6)
EDGES = st.sets(st.tuples(st.sampled_from(STATES), st.sampled_from(STATES)), max_size=9)


def component(number: int, edges: set[tuple[int, int]]) -> str:
    transitions = {
        state: "".join(f" transition goto s{end}" for begin, end in sorted(edges) if begin == state)
        for state in STATES
    }
    states = (f"marked state s{n} {{{text} }}" for n, text in transitions.items())
    return f"component C{number} {{ behaviour {{ initial {' '.join(states)} }} }}"


@given(st.lists(EDGES, min_size=1, max_size=3))
def test_of_random_components(components: list[set[tuple[int, int]]]) -> None:
    text = " ".join(component(number, edges) for number, edges in enumerate(components))
    graphs = [nx.DiGraph([e for e in edges if e[0] != e[1]]) for edges in components]
    expected = (
        sum(map(nx.dag_longest_path_length, graphs))
        if all(map(nx.is_directed_acyclic_graph, graphs))
        else None
    )
    assert longest_locally(plant_of(f"robot R {{ {text} }}")) == expected
