"""Shortest paths in an explicit solution, and what else explanations ask for."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from functools import cached_property
from operator import itemgetter

from robosc.expr.tree import Expr
from robosc.plant.automaton import Plant, PlantState
from robosc.plant.support import support
from robosc.supervisor import Guard
from robosc.synthesis.compiled_steps import Stepper
from robosc.synthesis.explicit.explicit_engine import (
    EventOutcomes,
    ExplicitSolution,
    changed,
    possible_events,
)
from robosc.synthesis.explicit.plant_states import PlantStates
from robosc.synthesis.faults import ExplicitFaults
from robosc.synthesis.time_limit import ExplanationTime

_target = itemgetter(1)
_MOST_TRIED = 2**17
"""States of the plant that are tried for a condition."""


class ExplicitSystem:
    """An explicit solution as :class:`robosc.synthesis.controlled_system.System`."""

    def __init__(
        self,
        solution: ExplicitSolution,
        plant_states: PlantStates,
        time: ExplanationTime | None = None,
    ) -> None:
        self.solution = solution
        self.time = time or ExplanationTime(math.inf)
        self._plant_states = plant_states
        self._engine = solution.engine
        self._states = solution.engine.found.states
        self._samples: dict[tuple[int, ...], list[PlantState]] = {}

    @property
    def plant(self) -> Plant:
        return self._engine.plant

    @property
    def nodes(self) -> int:
        return 0

    @cached_property
    def faults(self) -> ExplicitFaults:
        return ExplicitFaults(self._engine.stepper, self.is_good, self.time)

    @property
    def steps(self) -> ExplicitSystem:
        return self

    @property
    def states(self) -> Sequence[PlantState]:
        return self._states

    def number(self, state: PlantState) -> int:
        return self._engine.found.numbers[state]

    def is_good(self, state: PlantState) -> bool:
        return self._engine.found.numbers.get(state) in self.solution.good

    def lost_start(self) -> PlantState:
        starts = range(self._engine.found.starts)
        return self._states[next(n for n in starts if n not in self.solution.good)]

    def reaches(self, condition: Expr) -> bool:
        holds = self._engine.stepper.test(condition)
        return any(map(holds, self._alike(condition)))

    def plant_reaches(self, condition: Expr) -> bool | None:
        return self._plant_states.some(self._engine.stepper, condition, _MOST_TRIED)

    def longest_completion(self) -> int | None:
        return None

    def runs(self, exactly: bool) -> None:
        return None

    def nearest(self, condition: Expr) -> tuple[PlantState, ...] | None:
        if not self.reaches(condition):
            return None
        holds = self._engine.stepper.test(condition)
        for layer in self._layers:
            hits = [self._states[number] for number in layer if holds(self._states[number])]
            if hits:
                return self._path(self._engine.found.numbers[min(hits)])
        raise AssertionError("a controlled state is not reached")

    def _alike(self, condition: Expr) -> list[PlantState]:
        """Return controlled states that stand for all others in what a condition reads."""
        read = support(self.plant, condition)
        if read not in self._samples:
            key: Callable[[PlantState], object] = itemgetter(*read) if read else lambda state: ()
            sample = {key(self._states[n]): self._states[n] for n in self.solution.states}
            self._samples[read] = list(sample.values())
        return self._samples[read]

    @cached_property
    def _layers(self) -> list[list[int]]:
        """The controlled states by their distance from the initial ones."""
        layers = [list(range(self._engine.found.starts))]
        seen = set(layers[0])
        while layers[-1]:
            after = {t for number in layers[-1] for _, t in self.after(number)} - seen
            seen |= after
            layers.append(list(after))
        return layers[:-1]

    @cached_property
    def _distances(self) -> dict[int, int]:
        return {number: d for d, layer in enumerate(self._layers) for number in layer}

    @cached_property
    def _refused(self) -> set[tuple[int, int]]:
        return self._engine.refused(self.solution.good)

    @cached_property
    def _before(self) -> dict[int, list[tuple[int, int]]]:
        """Per controlled state the steps to it, as pairs of the event's number and the source."""
        before: dict[int, list[tuple[int, int]]] = {}
        for number in self.solution.states:
            for event, target in self.after(number):
                before.setdefault(target, []).append((event, number))
        return before

    def after(self, number: int) -> Sequence[tuple[int, int]]:
        steps = self._engine.found.after[number]
        if not self._refused and self.solution.states.issuperset(map(_target, steps)):
            return steps
        return [
            (event, target)
            for event, target in steps
            if target in self.solution.states and (number, event) not in self._refused
        ]

    def _path(self, number: int) -> tuple[PlantState, ...]:
        path = [number]
        while distance := self._distances[path[-1]]:
            steps = self._before[path[-1]]
            nearer = [(e, n) for e, n in steps if self._distances[n] == distance - 1]
            path.append(min(nearer, key=lambda step: (step[0], self._states[step[1]]))[1])
        return tuple(self._states[n] for n in reversed(path))


class GuardedSteps:
    """States under a supervisor and the steps between them, numbered as they are asked for."""

    def __init__(self, plant: Plant, guards: Sequence[Guard]) -> None:
        compiled = Stepper(plant).controlled(guards)
        events = [EventOutcomes(plant.events[each.number], each, plant) for each in compiled]
        self._possible = possible_events(plant, events)
        self._numbers: dict[PlantState, int] = {}
        self._after: dict[int, tuple[tuple[int, int], ...]] = {}
        self.states: list[PlantState] = []

    def number(self, state: PlantState) -> int:
        found = self._numbers.get(state)
        if found is None:
            found = self._numbers[state] = len(self.states)
            self.states.append(state)
        return found

    def after(self, number: int) -> tuple[tuple[int, int], ...]:
        found = self._after.get(number)
        if found is None:
            state = self.states[number]
            found = self._after[number] = tuple(
                (event.number, self.number(changed(state, change)))
                for event, outcomes in self._possible(state)
                if outcomes.changes and (event.test is None or event.test(state))
                for change in outcomes.changes
            )
        return found
