"""Care sets as arrays of the dense engine."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, replace
from math import prod
from typing import Any

import numpy as np

from robosc.expr.tree import Expr
from robosc.plant.automaton import Plant
from robosc.plant.support import support
from robosc.synthesis.dense.bitset import Bitset
from robosc.synthesis.dense.dimensions import Dim
from robosc.synthesis.dense.layout import Layout
from robosc.synthesis.guards.minimise import condition_of
from robosc.synthesis.guards.sum_of_products import Diagrams, TooLarge
from robosc.synthesis.vectorised import Bools, Indexes, evaluate_vectorised

_MOST_ROWS = 2**20


@dataclass(frozen=True, eq=False)
class DenseCareSet:
    """A :class:`~robosc.synthesis.guards.shorten.CareSet`: flat boolean arrays over dimensions."""

    plant: Plant
    dims: tuple[Dim, ...]
    allowed: Bools
    refused: Bools

    @classmethod
    def of(cls, layout: Layout, allowed: Bitset, refused: Bitset) -> DenseCareSet:
        return cls(layout.plant, layout.order, layout.flags(allowed), layout.flags(refused))

    @property
    def parts(self) -> tuple[tuple[int, ...], ...]:
        return tuple(dim.variables for dim in self.dims)

    @property
    def size(self) -> int:
        return prod(self.plant.sizes(variable for dim in self.dims for variable in dim.variables))

    def without(self, parts: Sequence[tuple[int, ...]]) -> DenseCareSet | None:
        dims, allowed, refused = self.dims, self.allowed, self.refused
        for part in parts:
            place = next(number for number, dim in enumerate(dims) if dim.variables == part)
            allowed, refused = _forget(allowed, dims, place), _forget(refused, dims, place)
            dims = dims[:place] + dims[place + 1 :]
            if np.logical_and(allowed, refused).any():
                return None
        return DenseCareSet(self.plant, dims, allowed, refused)

    def _columns(self, places: Indexes) -> list[Indexes]:
        """Return the positions in each dimension of states at some places."""
        shape = [dim.size for dim in self.dims]
        found: list[Indexes] = []
        for size in reversed(shape):
            found.append(places % size)
            places = places // size
        return found[::-1]

    def within(self, allowed: Expr, refused: Expr) -> DenseCareSet | None:
        left = []
        for states, condition in ((self.allowed, allowed), (self.refused, refused)):
            if not self._has(condition):
                return None
            left.append(states.copy())
            for places, holds in self._holding(states, condition):
                left[-1][places] = holds
        return replace(self, allowed=left[0], refused=left[1])

    def separates(self, condition: Expr) -> bool:
        return self._has(condition) and all(
            (holds == expected).all()
            for states, expected in ((self.allowed, True), (self.refused, False))
            for _, holds in self._holding(states, condition)
        )

    def _has(self, condition: Expr) -> bool:
        """Whether a condition reads no state variable that was projected away."""
        left = {variable for dim in self.dims for variable in dim.variables}
        return left.issuperset(support(self.plant, condition))

    def _holding(self, states: Bools, condition: Expr) -> Iterator[tuple[Indexes, Bools]]:
        """Yield the places of states, in chunks, and in which of them a condition holds."""
        variables = support(self.plant, condition)
        for start in range(0, len(states), _MOST_ROWS):
            places = start + np.flatnonzero(states[start : start + _MOST_ROWS])
            values = self._values(places)
            found = evaluate_vectorised(self.plant, condition, {a: values[a] for a in variables})
            yield places, found.astype(np.bool_)

    def _values(self, places: Indexes) -> dict[int, Indexes]:
        """Return the values per state variable of states at some places."""
        return {
            variable: dim.table[positions, number]
            for dim, positions in zip(self.dims, self._columns(places), strict=True)
            for number, variable in enumerate(dim.variables)
        }

    def condition(self, order: Callable[[int], Any]) -> Expr:
        variables = tuple(sorted(variable for dim in self.dims for variable in dim.variables))
        allowed, refused = self._rows(self.allowed, variables), self._rows(self.refused, variables)
        for variable in sorted(variables, key=order):
            kept = [number for number, other in enumerate(variables) if other != variable]
            fewer = _distinct(allowed[:, kept]), _distinct(refused[:, kept])
            if len(_distinct(np.concatenate(fewer))) == len(fewer[0]) + len(fewer[1]):
                variables = tuple(variables[number] for number in kept)
                allowed, refused = fewer
        diagrams = Diagrams(self.plant.sizes(variables))
        sets = diagrams.of_rows(_distinct(allowed)), diagrams.of_rows(_distinct(refused))
        return condition_of(self.plant, variables, diagrams, *sets)

    def _rows(self, states: Bools, variables: Sequence[int]) -> Indexes:
        if np.count_nonzero(states) > _MOST_ROWS:
            raise TooLarge("a guard reads too many values")
        places = np.flatnonzero(states)
        values = self._values(places)
        rows = np.empty((len(places), len(variables)), np.intp)
        for column, variable in enumerate(variables):
            rows[:, column] = values[variable]
        return rows


def _distinct(rows: Indexes) -> Indexes:
    """Return the distinct rows, sorted."""
    return np.unique(rows, axis=0)


def _forget(states: Bools, dims: Sequence[Dim], place: int) -> Bools:
    """Return the projection without one dimension."""
    count = dims[place].size
    after = prod(dim.size for dim in dims[place + 1 :])
    shaped = states.reshape(-1, count, after)
    found = shaped[:, 0, :].copy()
    for value in range(1, count):
        np.logical_or(found, shaped[:, value, :], out=found)
    return found.reshape(-1)
