"""A transition system as users read it: values on which a step does not depend are left out.

In most states most parts of an event's value make no difference, and listed one by one their
combinations would bury the few that do. A value of one part is listed as it is.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator, Sequence
from dataclasses import replace
from functools import cache
from itertools import groupby

from robosc.expr.traversal import path_text
from robosc.lazy_dataclasses import dataclass
from robosc.plant.automaton import Event, Plant, PlantState
from robosc.plant.step import Values, valuations
from robosc.supervisor import Step
from robosc.synthesis.controlled_system import tau_values
from robosc.synthesis.explore import Graph, GraphTransition


@dataclass(frozen=True, slots=True)
class Listed:
    """Transitions of a graph that differ only in parts of the event's value that do not matter.

    The event of ``step`` has only the parameters that matter; ``any`` names the others, ``values``
    is how many transitions these are.
    """

    source: int
    step: Step
    target: int
    any: tuple[str, ...] = ()
    values: int = 1


def listed(graph: Graph) -> Iterator[Listed]:
    """Yield the transitions of a graph in its order, each with those that are like it."""
    reductions = [_Reduction(event) for event in graph.plant.events]
    for (source, number), group in groupby(graph.transitions, key=lambda t: (t.source, t.event)):
        taken = list(group)
        event = graph.plant.events[number]
        if event.kind.of_component:
            yield from (_of_component(graph.plant, graph.states, event, t) for t in taken)
        else:
            yield from reductions[number].of(source, taken)


def _of_component(
    plant: Plant, states: Sequence[PlantState], event: Event, t: GraphTransition
) -> Listed:
    values = tau_values(plant, event, states[t.source], states[t.target])
    return Listed(t.source, Step(event, values), t.target)


class _Reduction:
    """Finds which parameters of one event matter in a state."""

    def __init__(self, event: Event) -> None:
        self._all = tuple(range(len(event.parameters)))
        self._event = event
        # What is known of the data tells one of several events from the others.
        self._free = [n for n in self._all if n not in event.known] if len(self._all) > 1 else []
        self._sizes = cache(self._count)
        self._reduced = cache(self._leave)

    def of(self, source: int, taken: Sequence[GraphTransition]) -> Iterator[Listed]:
        """Yield what is listed of the steps by the event from one state."""
        kept = self._all
        for parameter in self._free:
            fewer = tuple(other for other in kept if other != parameter)
            if self._suffices(fewer, taken):
                kept = fewer
        event, names = self._reduced(kept)
        alike: dict[Values, list[GraphTransition]] = {}
        for t in taken:
            alike.setdefault(_key(t.values, kept), []).append(t)
        for several in alike.values():
            step = Step(event, tuple(several[0].values[n] for n in kept))
            yield Listed(source, step, several[0].target, names, len(several))

    def _suffices(self, kept: tuple[int, ...], taken: Sequence[GraphTransition]) -> bool:
        """Whether whether and where the event leads is decided by some parameters alone."""
        targets: dict[Values, int] = {}
        found: Counter[Values] = Counter()
        for t in taken:
            values = _key(t.values, kept)
            if targets.setdefault(values, t.target) != t.target:
                return False
            found[values] += 1
        sizes = self._sizes(kept)
        return all(sizes[values] == number for values, number in found.items())

    def _count(self, kept: tuple[int, ...]) -> Counter[Values]:
        """Return with how many values of the event some parameters have each of theirs."""
        return Counter(_key(values, kept) for values in valuations(self._event))

    def _leave(self, kept: tuple[int, ...]) -> tuple[Event, tuple[str, ...]]:
        """Return the event with some parameters only, and the names of the others."""
        parameters = self._event.parameters
        names = (path_text(parameters[n].path) for n in self._all if n not in kept)
        event = replace(self._event, parameters=tuple(parameters[n] for n in kept))
        return event, tuple(names)


def _key(values: Values, kept: Sequence[int]) -> Values:
    """Return some of an event's values, told apart by their texts: 0.0 and -0.0 are equal."""
    return tuple(repr(values[n]) for n in kept)
