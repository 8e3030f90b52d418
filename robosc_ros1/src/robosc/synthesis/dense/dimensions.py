"""Dimensions of the array of states: one state variable, or several projected together."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from itertools import product

import numpy as np

from robosc.synthesis.dense.merging import Writes
from robosc.synthesis.vectorised import Indexes


@dataclass(frozen=True, eq=False)
class Dim:
    """State variables in one dimension: row i of ``table`` has their values at position i."""

    variables: tuple[int, ...]
    table: Indexes

    @property
    def size(self) -> int:
        return len(self.table)

    @cached_property
    def positions(self) -> dict[tuple[int, ...], int]:
        return {tuple(row): position for position, row in enumerate(self.table.tolist())}

    @cached_property
    def _spread(self) -> tuple[int, ...]:
        """One more than the largest value of each state variable."""
        return tuple(int(n) + 1 for n in self.table.max(axis=0))

    @cached_property
    def _codes(self) -> tuple[Indexes, Indexes]:
        """The rows as integer keys, ascending, and the position of each."""
        codes = np.ravel_multi_index(tuple(self.table.T), self._spread)
        order = np.argsort(codes)
        return codes[order], order

    def find(self, columns: Sequence[Indexes]) -> Indexes:
        """Return the positions of many rows, all of which exist; one array per state variable."""
        codes, order = self._codes
        found = np.searchsorted(codes, np.ravel_multi_index(tuple(columns), self._spread))
        return np.asarray(order[found], dtype=np.intp)

    def images(self, writes: Mapping[int, Writes]) -> list[tuple[int, ...]]:
        """Return, per position, those that writes of the dimension's state variables lead to.

        Combinations that are not in the table are unreachable and left out.
        """
        relations = [
            None if (found := writes.get(variable)) is None else _relation(found)
            for variable in self.variables
        ]
        images = []
        for row in self.table.tolist():
            choices = [
                (value,) if relation is None else relation.get(value, ())
                for value, relation in zip(row, relations, strict=True)
            ]
            image = (self.positions.get(new) for new in product(*choices))
            images.append(tuple(position for position in image if position is not None))
        return images


def _relation(writes: Writes) -> dict[int, tuple[int, ...]]:
    return {value: new for old, new in writes for value in old}
