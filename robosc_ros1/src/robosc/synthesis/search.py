"""Shortest paths in a dense solution: breadth first over arrays of states.

A frontier is an array of places in the layout; its states are decoded to one column per axis, and
each move is evaluated on all of them at once. Only the layers are kept: a path is found backwards,
by expanding each layer once more.
"""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from robosc.ir.automaton import Plant, PlantState
from robosc.model.expr import Expr
from robosc.synthesis.columns import Bools, Indexes, evaluate_columns
from robosc.synthesis.dense import DenseSolution
from robosc.synthesis.layout import Layout
from robosc.synthesis.moves import Condition, EventMoves, Move

__all__ = ["DenseSystem"]

_LARGEST_REPEAT = 2**22
"""The plant's own states are not kept; up to this size they are computed again when asked for."""


class DenseSystem:
    """A dense solution as :class:`robosc.synthesis.system.System`."""

    def __init__(self, solution: DenseSolution) -> None:
        self.solution = solution
        self.layout: Layout = solution.engine.layout
        self._layers: list[Indexes] = []
        self._seen: Bools | None = None
        self._plant: Bools | None = None

    @property
    def plant(self) -> Plant:
        return self.layout.plant

    def is_good(self, state: PlantState) -> bool:
        place = self.layout.index(state)
        return place is not None and bool(self.solution.good[place])

    def plant_reaches(self, condition: Expr) -> bool | None:
        if self.layout.size > _LARGEST_REPEAT:
            return None
        if self._plant is None:
            self._plant = self.solution.engine.plant_reach()
        engine = self.solution.engine
        return engine.count(self._plant, engine.compiler.condition(condition)) > 0

    def nearest(self, condition: Expr) -> tuple[PlantState, ...] | None:
        engine = self.solution.engine
        if not engine.count(self.solution.states, engine.compiler.condition(condition)):
            return None
        for number in range(self.solution.states.size):
            layer = self._layer(number)
            hits = np.flatnonzero(
                np.broadcast_to(
                    evaluate_columns(self.plant, condition, self._columns(layer)), layer.shape
                )
            )
            if len(hits):
                return self._path(number, int(layer[hits[0]]))
        raise AssertionError("a controlled state is not reached")

    def _layer(self, number: int) -> Indexes:
        """The states at a distance from the initial one; kept, since several questions use them."""
        if self._seen is None:
            initial = self.layout.index(self.plant.initial)
            assert initial is not None
            self._layers = [np.array([initial], dtype=np.intp)]
            self._seen = np.zeros(self.layout.size, np.bool_)
            self._seen[initial] = True
        while len(self._layers) <= number:
            fresh: list[Indexes] = []
            for _, after in self._successors(self._layers[-1]):
                new = np.unique(after[~self._seen[after]])
                self._seen[new] = True
                fresh.append(new)
            self._layers.append(np.sort(np.concatenate(fresh)))
        return self._layers[number]

    def _path(self, number: int, place: int) -> tuple[PlantState, ...]:
        places = [place]
        for layer in reversed(self._layers[:number]):
            places.append(self._predecessor(layer, places[-1]))
        return tuple(self.layout.state(each) for each in reversed(places))

    def _predecessor(self, layer: Indexes, target: int) -> int:
        for before, after in self._successors(layer):
            hits = np.flatnonzero(after == target)
            if len(hits):
                return int(before[hits[0]])
        raise AssertionError("a state without predecessor")

    # --- steps of many states at once

    def _successors(self, places: Indexes) -> Iterator[tuple[Indexes, Indexes]]:
        """Pairs of places before and after, event by event, under control."""
        states = self.solution.states
        for step in self.solution.engine.steps:
            for before, columns in self._event(step.moves, places):
                after = self._places(columns)
                kept = states[after]
                yield before[kept], after[kept]

    def _event(
        self, moves: EventMoves, places: Indexes
    ) -> Iterator[tuple[Indexes, dict[int, Indexes]]]:
        batches = [(places, self._columns(places))]
        if moves.event.requirement is not None:
            batches = [self._select(*batches[0], condition) for condition in moves.required]
        for stage in moves.stages:
            batches = [
                moved for batch in batches for move in stage for moved in _moved(*batch, move)
            ]
        yield from (batch for batch in batches if len(batch[0]))

    def _select(
        self, places: Indexes, columns: dict[int, Indexes], condition: Condition
    ) -> tuple[Indexes, dict[int, Indexes]]:
        kept = _holds(condition, columns, len(places))
        return places[kept], {axis: values[kept] for axis, values in columns.items()}

    def _columns(self, places: Indexes) -> dict[int, Indexes]:
        found: dict[int, Indexes] = {}
        for dim, stride in zip(self.layout.dims, self.layout.strides, strict=True):
            rows = dim.table[places // stride % dim.size]
            for column, axis in enumerate(dim.axes):
                found[axis] = rows[:, column]
        return found

    def _places(self, columns: dict[int, Indexes]) -> Indexes:
        total: Indexes = np.zeros(1, np.intp)
        for dim, stride in zip(self.layout.dims, self.layout.strides, strict=True):
            total = total + dim.find([columns[axis] for axis in dim.axes]) * stride
        return total


def _holds(condition: Condition, columns: dict[int, Indexes], count: int) -> Bools:
    found = np.ones(count, np.bool_)
    for axis, values in condition.allowed.items():
        found &= values[columns[axis]]
    for factor in condition.factors:
        found &= factor.test(columns)
    return found


def _moved(
    places: Indexes, columns: dict[int, Indexes], move: Move
) -> Iterator[tuple[Indexes, dict[int, Indexes]]]:
    """Where a move leads from the states in which it holds, once per combination of new values."""
    if not len(places):
        return
    kept = _holds(move.condition, columns, len(places))
    if not kept.any():
        return
    batches = [(places[kept], {axis: values[kept] for axis, values in columns.items()})]
    for axis, rectangles in move.writes.items():
        written = []
        for before, state in batches:
            for old, new in rectangles:
                here = np.isin(state[axis], old)
                chosen = {a: v[here] for a, v in state.items()}
                for value in new:
                    written.append(
                        (before[here], {**chosen, axis: np.full(int(here.sum()), value)})
                    )
        batches = written
    yield from batches
