"""Shortest paths in a symbolic solution: breadth first, one diagram per distance."""

from __future__ import annotations

from robosc.ir.automaton import Plant, PlantState
from robosc.model.expr import Expr
from robosc.synthesis.bdd_diagrams import Set
from robosc.synthesis.bdd_engine import SymbolicSolution

__all__ = ["SymbolicSystem"]


class SymbolicSystem:
    """A symbolic solution as :class:`robosc.synthesis.system.System`."""

    def __init__(self, solution: SymbolicSolution) -> None:
        self.solution = solution
        self.engine = solution.engine
        self.encoding = solution.engine.encoding
        self._layers: list[Set] = [self.encoding.initial]
        self._seen = self.encoding.initial

    @property
    def plant(self) -> Plant:
        return self.engine.plant

    def is_good(self, state: PlantState) -> bool:
        return self.encoding.state(state) & self.solution.good != self.encoding.diagrams.false

    def plant_reaches(self, condition: Expr) -> bool | None:
        # The plant's own states are not kept; what no state at all meets is known without them.
        return None if self.encoding.holds(condition) != self.encoding.diagrams.false else False

    def nearest(self, condition: Expr) -> tuple[PlantState, ...] | None:
        false = self.encoding.diagrams.false
        wanted = self.encoding.holds(condition) & self.solution.states
        if wanted == false:
            return None
        number = 0
        while (hits := self._layer(number) & wanted) == false:
            number += 1
        states = [self.encoding.least(hits)]
        for layer in reversed(self._layers[:number]):
            states.append(self._predecessor(layer, states[-1]))
        return tuple(reversed(states))

    def _layer(self, number: int) -> Set:
        """The states at a distance from the initial one; kept, since several questions use them."""
        while len(self._layers) <= number:
            new = self.engine.successors(self._layers[-1]) & self.solution.states & ~self._seen
            self._seen = self._seen | new
            self._layers.append(new)
        return self._layers[number]

    def _predecessor(self, layer: Set, target: PlantState) -> PlantState:
        after = self.encoding.state(target)
        for event in self.engine.events:
            before = self.engine.required_preimage(event, after) & layer
            if before != self.encoding.diagrams.false:
                return self.encoding.least(before)
        raise AssertionError("a state without predecessor")
