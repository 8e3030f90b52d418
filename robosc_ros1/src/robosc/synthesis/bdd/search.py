"""Short paths in a symbolic solution.

The search is breadth first, one diagram per distance, as long as the diagrams stay small: then a
path is a shortest one. The states at one distance can take far larger diagrams than all states
together, so in a large system a path goes backwards through the iterates of the fixpoint, from the
first one that contains a state to the one before. Every step is one of the controlled system, and
the path is short, usually a shortest one.
"""

from __future__ import annotations

from bisect import bisect_left
from collections.abc import Sequence
from functools import cached_property

from robosc.ir.automaton import Plant, PlantState
from robosc.model.expr import Expr
from robosc.synthesis.bdd.chaining import Iterates
from robosc.synthesis.bdd.controller import SymbolicController
from robosc.synthesis.bdd.manager import Bdd
from robosc.synthesis.bdd.symbolic_engine import SymbolicSolution
from robosc.synthesis.system import Runs

_MOST_NODES = 50_000
"""Nodes of all layers together above which the search is no longer breadth first."""


class SymbolicSystem:
    """A symbolic solution as :class:`robosc.synthesis.system.System`."""

    def __init__(self, solution: SymbolicSolution, most_nodes: int = _MOST_NODES) -> None:
        self.solution = solution
        self.engine = solution.engine
        self.encoding = solution.engine.encoding
        self._false = self.encoding.manager.false
        self._layers: list[Bdd] = [self.encoding.initial]
        self._seen = self.encoding.initial
        self._nodes_left = most_nodes

    @property
    def plant(self) -> Plant:
        return self.engine.plant

    def is_good(self, state: PlantState) -> bool:
        return self.encoding.contains(self.solution.good, state)

    def lost_start(self) -> PlantState:
        return self.encoding.pick(self.encoding.initial & ~self.solution.good)

    def plant_reaches(self, condition: Expr) -> bool | None:
        return self.encoding.holds(condition) & self.solution.plant_reach != self._false

    def longest_completion(self) -> int | None:
        return self.engine.longest_completion(self.solution.states)

    def runs(self) -> Runs | None:
        try:
            return SymbolicController(self.solution).runs()
        except MemoryError:
            return None

    def nearest(self, condition: Expr) -> tuple[PlantState, ...] | None:
        """Return a path to a state with the condition: a shortest one unless that is too costly."""
        self.encoding.manager.make_room()
        wanted = self.encoding.holds(condition) & self.solution.states
        if wanted == self._false:
            return None
        number = 0
        while (layer := self._layer(number)) is not None:
            if layer & wanted != self._false:
                return self._back(number, self.encoding.least(layer & wanted))
            number += 1
        return self._through_iterates(wanted)

    # --- breadth first

    def _layer(self, number: int) -> Bdd | None:
        """Return the states at a distance from the initial ones; None if too costly.

        Layers are stored for later queries.
        """
        while len(self._layers) <= number:
            if self._nodes_left <= 0:
                return None
            self.encoding.manager.make_room()
            try:
                new = self.engine.successors(self._layers[-1]) & self.solution.states & ~self._seen
                self._seen = self._seen | new
            except MemoryError:
                self._nodes_left = 0
                return None
            self._layers.append(new)
            self._nodes_left -= self.encoding.manager.size(new)
        return self._layers[number]

    def _back(self, number: int, target: PlantState) -> tuple[PlantState, ...]:
        states = [target]
        for layer in reversed(self._layers[:number]):
            states.append(self._predecessor(layer, states[-1]))
        return tuple(reversed(states))

    def _predecessor(self, layer: Bdd, target: PlantState) -> PlantState:
        after = self.encoding.state(target)
        initial = self.plant.initial
        moved = {variable for variable, value in enumerate(target) if value != initial[variable]}
        # The last event on a shortest path most likely wrote what differs from the start.
        for event in sorted(self.engine.events, key=lambda e: e.writes.isdisjoint(moved)):
            before = self.engine.required_preimage(event, after) & layer
            if before != self._false:
                return self.encoding.least(before)
        raise AssertionError("a state without predecessor")

    # --- through the iterates of the fixpoint

    @cached_property
    def _iterates(self) -> Iterates:
        return self.engine.iterates(self.solution.states)

    def _through_iterates(self, wanted: Bdd) -> tuple[PlantState, ...]:
        iterates = self._iterates
        number = bisect_left(iterates, True, key=lambda item: item[1] & wanted != self._false)
        states = [self.encoding.pick(iterates[number][1] & wanted)]
        while number > 0:
            event = self.engine.events[iterates[number][0]]
            after = self.encoding.state(states[-1])
            before = self.encoding.pick(
                self.engine.required_preimage(event, after) & iterates[number - 1][1]
            )
            states.append(before)
            number = self._first(self.encoding.assignment(before), number)
        return tuple(reversed(states))

    def _first(self, assignment: Sequence[tuple[int, bool]], before: int) -> int:
        """Return the first iterate before a position that contains a state."""
        contains = self.encoding.manager.contains
        return bisect_left(
            self._iterates, True, hi=before, key=lambda item: contains(item[1], assignment)
        )
