"""The graph of the explicit verifier: numbered states, steps forward and backward."""

from __future__ import annotations

from array import array
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field


@dataclass
class CodedGraph:
    """The steps that the requirements permit, and which of them the guards allow.

    States are numbered in the order of discovery, the ``starts`` initial ones first; ``codes`` and
    ``number`` map numbers to coded states and back. The steps of state ``i`` are those from
    ``first[i]`` to ``first[i + 1]``: ``targets``, and ``labels`` of event and values, complemented
    where the guard forbids the step. Allowed self-loops are only counted, in ``allowed``, which has
    the number of allowed steps per state. ``outcomes`` has, for each label of a command with
    several outcomes, the labels of all of them.
    """

    codes: list[int]
    number: dict[int, int]
    starts: int
    outcomes: Mapping[int, range]
    first: array[int] = field(default_factory=lambda: array("q", [0]))
    targets: array[int] = field(default_factory=lambda: array("i"))
    labels: array[int] = field(default_factory=lambda: array("i"))
    allowed: array[int] = field(default_factory=lambda: array("i"))
    unsafe: dict[int, str] = field(default_factory=dict)
    violations: dict[int, int] = field(default_factory=dict)  # state: label of the step

    def steps(self, state: int) -> Iterator[tuple[int, int]]:
        """Yield the target and label of each step of a state."""
        for step in range(self.first[state], self.first[state + 1]):
            yield self.targets[step], self.labels[step]

    def staying(self, state: int, label: int, within: bytearray) -> bool:
        """Whether all outcomes of a command in a state are ``within``."""
        labels = self.outcomes.get(label if label >= 0 else ~label)
        return labels is None or all(
            within[target]
            for target, other in self.steps(state)
            if (other if other >= 0 else ~other) in labels
        )


@dataclass
class Backward:
    """The steps of a graph by target."""

    first: array[int]
    sources: array[int]
    labels: array[int]

    @classmethod
    def of(cls, graph: CodedGraph) -> Backward:
        count = len(graph.codes)
        first = array("q", bytes(8 * (count + 2)))
        for target in graph.targets:
            first[target + 2] += 1
        for state in range(2, count + 2):
            first[state] += first[state - 1]
        sources, labels = array("i", graph.targets), array("i", graph.labels)
        for source in range(count):
            for step in range(graph.first[source], graph.first[source + 1]):
                place = first[graph.targets[step] + 1]
                first[graph.targets[step] + 1] = place + 1
                sources[place] = source
                labels[place] = graph.labels[step]
        return cls(first, sources, labels)

    def steps(self, target: int) -> Iterator[tuple[int, int]]:
        """Yield the source and label of each step to a state."""
        start, end = self.first[target], self.first[target + 1]
        return zip(self.sources[start:end], self.labels[start:end], strict=True)


@dataclass
class Reached:
    """The states reached under the guards, in breadth-first order.

    An initial state is its own parent; ``among`` is 1 per reached state, else 0.
    """

    order: list[int]
    parents: dict[int, int]
    among: bytearray

    @classmethod
    def of(cls, graph: CodedGraph) -> Reached:
        order, among = list(range(graph.starts)), bytearray(len(graph.codes))
        parents = {state: state for state in order}
        among[: graph.starts] = b"\1" * graph.starts
        for state in order:
            for target, label in graph.steps(state):
                if label >= 0 and not among[target]:
                    among[target] = 1
                    parents[target] = state
                    order.append(target)
        return cls(order, parents, among)
