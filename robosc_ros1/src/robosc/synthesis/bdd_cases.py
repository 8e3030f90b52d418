"""What a guard must tell apart, as decision diagrams hold it; and guards over very many axes.

Most guards read a few axes: these become a table, and what is made of it is the same for every
engine (:mod:`robosc.synthesis.cover`). A guard that reads so many that no table holds them (never
the last free place of thirty) is covered by boxes found on the diagrams themselves.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from math import prod

import numpy as np

from robosc.ir.automaton import Plant
from robosc.ir.expr import conjunction, disjunction, negation
from robosc.model.expr import Expr
from robosc.synthesis.bdd_diagrams import Set
from robosc.synthesis.bdd_encoding import Encoding
from robosc.synthesis.columns import Bools
from robosc.synthesis.cover import Table, condition_of

__all__ = ["SymbolicCases", "TooWide", "wide_condition"]

_LARGEST_TABLE = 2**16


class TooWide(Exception):
    """A guard reads more axes than a table may have places."""


@dataclass(frozen=True, eq=False)
class SymbolicCases:
    """Two disjoint sets over the axes that are left. See ``guards.Cases``."""

    encoding: Encoding
    axes: tuple[int, ...]
    allowed: Set
    refused: Set

    @property
    def parts(self) -> tuple[tuple[int, ...], ...]:
        return tuple((axis,) for axis in self.axes)

    def without(self, part: tuple[int, ...]) -> SymbolicCases | None:
        diagrams = self.encoding.diagrams
        cube = self.encoding.now(part)
        allowed = diagrams.exists(self.allowed, cube)
        refused = diagrams.exists(self.refused, cube)
        if allowed & refused != diagrams.false:
            return None
        left = tuple(axis for axis in self.axes if axis not in part)
        return SymbolicCases(self.encoding, left, allowed, refused)

    def table(self) -> Table:
        """Raises TooWide if it would have too many places."""
        if self.size > _LARGEST_TABLE:
            raise TooWide
        axes = tuple(sorted(self.axes))
        return Table(axes, self._array(self.allowed, axes), self._array(self.refused, axes))

    @property
    def size(self) -> int:
        return prod(self.encoding.plant.axes[axis].size for axis in self.axes)

    def _array(self, states: Set, axes: Sequence[int]) -> Bools:
        diagrams = self.encoding.diagrams
        shape = tuple(self.encoding.plant.axes[axis].size for axis in axes)
        known: dict[tuple[int, Set], Bools] = {}

        def array(depth: int, states: Set) -> Bools:
            if depth == len(axes) or states == diagrams.false:
                return np.full(shape[depth:], states != diagrams.false, np.bool_)
            if (depth, states) not in known:
                axis = axes[depth]
                cube = self.encoding.now([axis])
                known[depth, states] = np.stack([
                    array(
                        depth + 1,
                        diagrams.conjoin_exists(states, self.encoding.value(axis, index), cube),
                    )
                    for index in range(shape[depth])
                ])  # fmt: skip
            return known[depth, states]

        return array(0, states)


# --- guards over very many axes ------------------------------------------------------------------


def wide_condition(cases: SymbolicCases) -> Expr:
    """An expression that holds in what is allowed and fails in what is refused."""
    for part in sorted(cases.parts, reverse=True):
        cases = cases.without(part) or cases
    cover = _Cover(cases)
    positive = disjunction(cover.conjunctions(cases.allowed, cases.refused))
    negative = conjunction(
        negation(box) for box in cover.conjunctions(cases.refused, cases.allowed)
    )
    return min(positive, negative, key=lambda expr: len(str(expr)))


_Box = dict[int, frozenset[int]]
"""The values that an axis may have, for each axis that matters."""


class _Cover:
    """Boxes as in :mod:`robosc.synthesis.cover`, told from the sets themselves."""

    def __init__(self, cases: SymbolicCases) -> None:
        self.encoding = cases.encoding
        self.plant: Plant = cases.encoding.plant
        self.axes = tuple(sorted(cases.axes))

    def conjunctions(self, inside: Set, outside: Set) -> Iterable[Expr]:
        """Expressions that together hold in all of ``inside``, and nowhere in ``outside``."""
        false = self.encoding.diagrams.false
        left = inside
        while left != false:
            seed = self.encoding.pick(left)
            boxes = [self._grow(seed, outside, order) for order in (self.axes, self.axes[::-1])]
            best = max(boxes, key=lambda box: self.encoding.count(left & self._set(box)))
            left = left & ~self._set(best)
            yield conjunction(self._literal(axis, best[axis]) for axis in sorted(best))

    def _grow(self, seed: Sequence[int], outside: Set, order: Sequence[int]) -> _Box:
        box: _Box = {axis: frozenset((seed[axis],)) for axis in self.axes}
        for axis in order:
            rest = {other: values for other, values in box.items() if other != axis}
            near = outside & self._set(rest)
            values = frozenset(
                index
                for index in range(self.plant.axes[axis].size)
                if near & self.encoding.value(axis, index) == self.encoding.diagrams.false
            )
            box = rest if len(values) == self.plant.axes[axis].size else {**rest, axis: values}
        return box

    def _set(self, box: Mapping[int, frozenset[int]]) -> Set:
        result = self.encoding.diagrams.true
        for axis in sorted(box, key=self.encoding.place, reverse=True):
            result = self.encoding.values(axis, box[axis]) & result
        return result

    def _literal(self, axis: int, values: frozenset[int]) -> Expr:
        allowed = np.array([v in values for v in range(self.plant.axes[axis].size)], np.bool_)
        return condition_of(self.plant, Table((axis,), allowed, ~allowed))
