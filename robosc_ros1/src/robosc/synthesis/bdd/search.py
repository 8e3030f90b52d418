"""Short paths in a symbolic solution.

The search is breadth first, one diagram per distance, as long as the diagrams stay small: then a
path is a shortest one. The states at one distance can take far larger diagrams than all states
together, so in a large system only some events are looked at (:mod:`robosc.synthesis.bdd.cones`),
and where that is too much as well, or the time for explanations is over, no path is looked for.
"""

from __future__ import annotations

import math
from collections.abc import Iterable
from functools import cached_property

from robosc import limits
from robosc.expr.tree import Expr
from robosc.plant.automaton import Plant, PlantState
from robosc.plant.support import support
from robosc.supervisor import Guard
from robosc.synthesis.bdd.cones import Cones
from robosc.synthesis.bdd.faults import SymbolicFaults
from robosc.synthesis.bdd.manager import Bdd
from robosc.synthesis.bdd.run_to_completion import SymbolicController
from robosc.synthesis.bdd.symbolic_engine import SymbolicSolution
from robosc.synthesis.controlled_system import Runs
from robosc.synthesis.explicit.search import GuardedSteps
from robosc.synthesis.time_limit import ExplanationTime

_FEW_IMAGES = 100
"""Images for a layer; with more of them, layers of fewer nodes take as long."""


class SymbolicSystem:
    """A symbolic solution as :class:`robosc.synthesis.controlled_system.System`."""

    def __init__(
        self,
        solution: SymbolicSolution,
        guards: Iterable[Guard],
        most_nodes: int = limits.BREADTH_FIRST_NODES,
        most_work: int = limits.TRACE_NODES,
        time: ExplanationTime | None = None,
    ) -> None:
        self.solution = solution
        self.engine = solution.engine
        self.time = time or ExplanationTime(math.inf)
        self.encoding = solution.engine.encoding
        self._false = self.encoding.manager.false
        self._layers: list[Bdd] = [self.encoding.initial]
        self._seen = self.encoding.initial
        self._nodes_left = most_nodes
        self._images = max(_FEW_IMAGES, sum(map(len, self.engine.required_disjuncts)))
        self._guards = tuple(guards)
        self._cones = Cones(solution, self._guards, most_work)

    @property
    def plant(self) -> Plant:
        return self.engine.plant

    @property
    def nodes(self) -> int:
        return self.encoding.manager.nodes

    @cached_property
    def faults(self) -> SymbolicFaults:
        return SymbolicFaults(self.solution, self.time)

    @cached_property
    def steps(self) -> GuardedSteps:
        return GuardedSteps(self.plant, self._guards)

    def is_good(self, state: PlantState) -> bool:
        return self.encoding.contains(self.solution.good, state)

    def lost_start(self) -> PlantState:
        return self.encoding.pick(self.encoding.initial & ~self.solution.good)

    def reaches(self, condition: Expr) -> bool:
        return self.encoding.meets(self.solution.states, condition)

    def plant_reaches(self, condition: Expr) -> bool | None:
        return self.encoding.meets(self.solution.plant_reach, condition)

    def longest_completion(self) -> int | None:
        return self.engine.longest_completion(self.solution.states)

    def runs(self, exactly: bool) -> Runs | None:
        try:
            return SymbolicController(self.solution).runs(exactly)
        except MemoryError:
            return None

    def nearest(self, condition: Expr) -> tuple[PlantState, ...] | None:
        """Return a path to a state with the condition: a shortest one unless that is too costly.

        If even a longer one is, the path is only the state.
        """
        self.encoding.manager.make_room()
        wanted = self.encoding.where(self.solution.states, condition)
        if wanted == self._false:
            return None
        number = 0
        while (layer := self._layer(number)) is not None:
            if layer & wanted != self._false:
                return self._back(number, self.encoding.least(layer & wanted))
            number += 1
        path = None
        if not self.time.is_over:
            path = self._cones.path(wanted, frozenset(support(self.plant, condition)))
        return (self.encoding.least(wanted),) if path is None else path

    # --- breadth first

    def _layer(self, number: int) -> Bdd | None:
        """Return the states at a distance from the initial ones; None if too costly.

        Layers are stored for later queries.
        """
        while len(self._layers) <= number:
            if self._nodes_left <= 0 or self.time.is_over:
                return None
            self.encoding.manager.make_room()
            try:
                new = self.engine.successors(self._layers[-1]) & self.solution.states & ~self._seen
                self._seen = self._seen | new
            except MemoryError:
                self._nodes_left = 0
                return None
            self._layers.append(new)
            self._nodes_left -= self.encoding.manager.size(new) * self._images // _FEW_IMAGES
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
