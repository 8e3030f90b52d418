"""The states that a plant reaches without its requirements, in independent parts."""

from __future__ import annotations

from functools import cached_property
from itertools import product
from math import prod

from robosc.expr.tree import Expr
from robosc.plant.automaton import Plant
from robosc.plant.support import support
from robosc.synthesis.compiled_steps import Stepper
from robosc.synthesis.decomposition import parts_without_requirements
from robosc.synthesis.explicit.explicit_engine import Limit, ReachedStates, changed, outcomes_of


class PlantStates:
    """The states that a plant reaches without its requirements, in independent parts."""

    def __init__(self, plant: Plant) -> None:
        self._plant = plant

    @cached_property
    def _parts(self) -> list[tuple[tuple[int, ...], ReachedStates]]:
        """Per part its variables, by number, and its states."""
        found = []
        for part in parts_without_requirements(self._plant):
            variables = ((variable.kind, variable.name) for variable in part.variables)
            numbers = tuple(self._plant.variable_index[variable] for variable in variables)
            events = outcomes_of(part, Stepper(part), False)
            found.append((numbers, ReachedStates(part, events, lambda state: True)))
        return found

    def search(self, limit: Limit) -> None:
        """Find all of them, from where a search ended before.

        Raises:
            TooMany: by ``limit``.
        """
        for _, states in self._parts:
            states.search(limit)

    @property
    def count(self) -> int:
        return prod(len(states.states) for _, states in self._parts)

    def some(self, stepper: Stepper, condition: Expr, most: int) -> bool | None:
        """Whether a state fulfils a condition; None: more than ``most`` would have to be tried."""
        read = set(support(self._plant, condition))
        columns: list[list[tuple[tuple[int, int], ...]]] = []
        for variables, states in self._parts:
            own = [(place, v) for place, v in enumerate(variables) if v in read]
            if own:
                values = {tuple((v, s[place]) for place, v in own) for s in states.states}
                columns.append(list(values))
        if prod(map(len, columns)) > most:
            return None
        holds = stepper.test(condition)
        initial = self._plant.initial
        return any(
            holds(changed(initial, (pair for part in parts for pair in part)))
            for parts in product(*columns)
        )
