"""Shortest paths in a dense solution: breadth-first search over arrays of states.

A layer is an array of places in the layout; its states are decoded to one column per state
variable, and each rule is evaluated on all of them at once. Only the layers are stored: a path is
found backwards, by expanding each layer once more.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import NDArray

from robosc.expr.tree import Expr
from robosc.plant.automaton import Plant, PlantState
from robosc.synthesis.compiled_steps import Stepper
from robosc.synthesis.dense.bitset import WORD, Bitset, add, members, places
from robosc.synthesis.dense.dense_engine import DenseSolution, EventOperations
from robosc.synthesis.dense.layout import Layout
from robosc.synthesis.dense.merging import Condition, TransitionRule, Writes
from robosc.synthesis.faults import ExplicitFaults
from robosc.synthesis.time_limit import ExplanationTime
from robosc.synthesis.vectorised import Bools, Indexes

_LARGEST_REPEAT = 2**22
"""Layout size up to which the states of the plant, which are not stored, are computed again."""


class DenseSystem:
    """A dense solution as :class:`robosc.synthesis.controlled_system.System`."""

    def __init__(self, solution: DenseSolution, time: ExplanationTime | None = None) -> None:
        self.solution = solution
        self.time = time or ExplanationTime(math.inf)
        self.layout: Layout = solution.engine.layout
        self._layers: list[NDArray[Any]] = []
        self._seen: Bitset | None = None
        self._plant: Bitset | None = None

    @property
    def plant(self) -> Plant:
        return self.layout.plant

    @cached_property
    def faults(self) -> ExplicitFaults:
        return ExplicitFaults(Stepper(self.plant), self.is_good, self.time)

    def is_good(self, state: PlantState) -> bool:
        place = self.layout.index(state)
        return place is not None and bool(members(self.solution.good, np.array([place]))[0])

    def lost_start(self) -> PlantState:
        starts = self.layout.starts()
        return self.layout.state(int(starts[~members(self.solution.good, starts)][0]))

    def reaches(self, condition: Expr) -> bool:
        return bool(self.solution.engine.meeting(self.solution.states, condition).any())

    def plant_reaches(self, condition: Expr) -> bool | None:
        if self.layout.size > _LARGEST_REPEAT:
            return None
        if self._plant is None:
            self._plant = self.solution.engine.plant_reach()
        return bool(self.solution.engine.meeting(self._plant, condition).any())

    def longest_completion(self) -> int | None:
        return None

    def runs(self) -> None:
        return None

    def nearest(self, condition: Expr) -> tuple[PlantState, ...] | None:
        wanted = self.solution.engine.meeting(self.solution.states, condition)
        if not wanted.any():
            return None
        for number in range(self.layout.size):
            layer = self._layer(number)
            assert len(layer), "a controlled state is not reached"
            hits = np.flatnonzero(members(wanted, layer))
            if len(hits):
                return self._path(number, int(layer[hits[0]]))
        raise AssertionError("a controlled state is not reached")

    def _layer(self, number: int) -> Indexes:
        """Return the states at a distance from the initial ones; stored for later queries."""
        if self._seen is None:
            self._seen = self.layout.nothing()
            self._keep(self.layout.starts())
        while len(self._layers) <= number:
            fresh: list[Indexes] = []
            for _, after in self._successors(self._stored(len(self._layers) - 1)):
                new = np.unique(after[~members(self._seen, after)])
                add(self._seen, new)
                fresh.append(new)
            self._keep(np.sort(np.concatenate(fresh)))
        return self._stored(number)

    def _keep(self, layer: Indexes) -> None:
        """Store a layer in whichever form is smaller."""
        assert self._seen is not None
        add(self._seen, layer)
        if layer.nbytes <= self._seen.nbytes:
            self._layers.append(layer)
        else:
            self._layers.append(self.layout.of(layer))

    def _stored(self, number: int) -> Indexes:
        layer = self._layers[number]
        return places(layer) if layer.dtype == WORD else layer.astype(np.intp, copy=False)

    def _path(self, number: int, place: int) -> tuple[PlantState, ...]:
        places = [place]
        for distance in reversed(range(number)):
            places.append(self._predecessor(self._stored(distance), places[-1]))
        return tuple(self.layout.state(each) for each in reversed(places))

    def _predecessor(self, layer: Indexes, target: int) -> int:
        """Return a state of a layer from which an event leads to the target, the first event first.

        Only states are tried that differ from the target in no variable that the event keeps.
        """
        columns, state = self.layout.columns(layer), self.layout.state(target)
        changed = [columns[variable] != state[variable] for variable in range(len(state))]
        nothing = np.zeros(len(layer), np.int32)
        differing = sum(changed, nothing)
        for step in self.solution.engine.steps:
            own = (changed[variable] for variable in step.event.writes)
            near = layer[sum(own, nothing) == differing]
            if len(near):
                start = _Batch(near, self.layout.columns(near), frozenset())
                for before, after in self._steps(step, start):
                    hits = np.flatnonzero(after == target)
                    if len(hits):
                        return int(before[hits[0]])
        raise AssertionError("a state without predecessor")

    # --- steps of many states at once

    def _successors(self, places: Indexes) -> Iterator[tuple[Indexes, Indexes]]:
        """Yield pairs of places before and after each event, under control."""
        start = _Batch(places, self.layout.columns(places), frozenset())
        for step in self.solution.engine.steps:
            yield from self._steps(step, start)

    def _steps(self, step: EventOperations, start: _Batch) -> Iterator[tuple[Indexes, Indexes]]:
        """The same for one event."""
        states = self.solution.states
        batches = [start]
        if step.event.requirement is not None:
            batches = [start.where(condition) for condition in step.rules.required]
        for stage in step.rules.stages:
            batches = [moved for batch in batches for rule in stage for moved in batch.moved(rule)]
        moves = [(batch.places, self._after(batch)) for batch in batches if len(batch.places)]
        leaving = [before[~members(states, after)] for before, after in moves]
        for before, after in moves:
            kept = members(states, after)
            if step.event.branches:  # refused if any of its outcomes is outside
                kept &= ~np.isin(before, np.concatenate(leaving))
            yield before[kept], after[kept]

    def _after(self, batch: _Batch) -> Indexes:
        """Return the places of the states after the steps of a batch."""
        after = batch.places
        for number in {self.layout.home[variable][0] for variable in batch.written}:
            dim, stride = self.layout.dims[number], self.layout.strides[number]
            positions = dim.find([batch.columns[variable] for variable in dim.variables])
            after = after + (positions - self.layout.position(number, batch.places)) * stride
        return after


@dataclass(frozen=True, eq=False, slots=True)
class _Batch:
    """States in the course of an event: their places before it, and their current values."""

    places: Indexes
    columns: dict[int, Indexes]
    written: frozenset[int]

    def where(self, condition: Condition) -> _Batch:
        """Return those that satisfy a condition."""
        kept = np.ones(len(self.places), np.bool_)
        for variable, values in condition.allowed.items():
            kept &= values[self.columns[variable]]
        for factor in condition.factors:
            kept &= factor.test(self.columns)
        return self._only(kept)

    def moved(self, rule: TransitionRule) -> Iterator[_Batch]:
        """Yield the batch after a rule, once per combination of new values."""
        batches = [self.where(rule.condition)]
        for variable, writes in rule.writes.items():
            batches = [
                written
                for batch in batches
                if len(batch.places)
                for written in batch._written(variable, writes)
            ]
        yield from batches

    def _written(self, variable: int, writes: Writes) -> Iterator[_Batch]:
        """Yield the batches after a write; one for all old values that have one new value."""
        most = 1 + max(max(old) for old, _ in writes)
        single = np.full(most, -1)
        for old, new in writes:
            if len(new) == 1:
                single[list(old)] = new[0]
                continue
            several = np.zeros(most, np.bool_)
            several[list(old)] = True
            for value in new:
                yield self._changed(variable, np.where(several, value, -1))
        yield self._changed(variable, single)

    def _changed(self, variable: int, new: Indexes) -> _Batch:
        """Return the batch with new values by old one; states where it is -1 or missing go."""
        values = self.columns[variable]
        indexes = np.full(len(values), -1)
        known = values < len(new)
        indexes[known] = new[values[known]]
        batch = self._only(indexes >= 0)
        columns = {**batch.columns, variable: indexes[indexes >= 0]}
        return _Batch(batch.places, columns, self.written | {variable})

    def _only(self, kept: Bools) -> _Batch:
        if kept.all():
            return self
        columns = {variable: values[kept] for variable, values in self.columns.items()}
        return _Batch(self.places[kept], columns, self.written)
