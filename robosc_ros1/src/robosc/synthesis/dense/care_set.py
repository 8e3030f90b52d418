"""What a guard must tell apart, as the dense engine holds it."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from math import prod

import numpy as np

from robosc.ir.automaton import Plant
from robosc.synthesis.dense.bitset import Bitset
from robosc.synthesis.dense.layout import Dim, Layout
from robosc.synthesis.minimise import Table
from robosc.synthesis.vectorised import Bools

__all__ = ["DenseCareSet"]


@dataclass(frozen=True, eq=False)
class DenseCareSet:
    """Two disjoint sets over dimensions, as flat arrays. See ``guards.Cases``."""

    plant: Plant
    dims: tuple[Dim, ...]
    allowed: Bools
    refused: Bools

    @classmethod
    def of(cls, layout: Layout, allowed: Bitset, refused: Bitset) -> DenseCareSet:
        return cls(layout.plant, layout.order, layout.flags(allowed), layout.flags(refused))

    @property
    def parts(self) -> tuple[tuple[int, ...], ...]:
        return tuple(dim.axes for dim in self.dims)

    def without(self, part: tuple[int, ...]) -> DenseCareSet | None:
        place = self.parts.index(part)
        allowed = _forget(self.allowed, self.dims, place)
        refused = _forget(self.refused, self.dims, place)
        if np.logical_and(allowed, refused).any():
            return None
        return DenseCareSet(
            self.plant, self.dims[:place] + self.dims[place + 1 :], allowed, refused
        )

    def table(self) -> Table:
        axes = tuple(sorted(axis for dim in self.dims for axis in dim.axes))
        shape = tuple(self.plant.variables[axis].size for axis in axes)
        return Table(
            axes, self._spread(self.allowed, axes, shape), self._spread(self.refused, axes, shape)
        )

    def _spread(self, states: Bools, axes: tuple[int, ...], shape: tuple[int, ...]) -> Bools:
        places = np.flatnonzero(states)
        values: dict[int, np.ndarray[tuple[int, ...], np.dtype[np.intp]]] = {}
        stride = len(states)
        for dim in self.dims:
            stride //= dim.size
            rows = dim.table[places // stride % dim.size]
            for column, axis in enumerate(dim.axes):
                values[axis] = rows[:, column]
        found = np.zeros(shape, np.bool_)
        if len(places):
            found[tuple(values[axis] for axis in axes)] = True
        return found


def _forget(states: Bools, dims: Sequence[Dim], place: int) -> Bools:
    """The projection that leaves one dimension out."""
    count = dims[place].size
    after = prod(dim.size for dim in dims[place + 1 :])
    shaped = states.reshape(-1, count, after)
    found = shaped[:, 0, :].copy()
    for value in range(1, count):
        np.logical_or(found, shaped[:, value, :], out=found)
    return found.reshape(-1)
