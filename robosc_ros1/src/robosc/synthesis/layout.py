"""States as places in one flat boolean array, and events as copies between slices of it.

The array has one dimension (:class:`Dim`) per axis, or per group of axes that depend on each other:
such a group is *folded* into one dimension that has only the combinations that can occur. A move of
the plant becomes *operations*, each from slices to slices of one shape. numpy allows 32 dimensions;
neighbours that an operation treats alike are merged, which is only another view of the same memory.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass
from functools import cached_property
from itertools import product
from math import prod

import numpy as np

from robosc.ir.automaton import Plant, PlantState
from robosc.synthesis.columns import Bools, Indexes
from robosc.synthesis.moves import Condition, Factor, Move, Writes

__all__ = ["Dim", "Layout", "Operation"]

_LARGEST_GRID = 2**22
_LARGEST_STEP = 2**22
_MOST_DIMENSIONS = 24
_SHORT = 16
"""Inner loops shorter than this cost more than what is done in them; they become operations."""
_WORTH_UNROLLING = 2**9


@dataclass(frozen=True, eq=False)
class Dim:
    """Axes in one dimension: row i of ``table`` are their values at place i."""

    axes: tuple[int, ...]
    table: Indexes

    @property
    def size(self) -> int:
        return len(self.table)

    @cached_property
    def _spread(self) -> tuple[int, ...]:
        """One more than the largest value of each axis."""
        return tuple(int(n) + 1 for n in self.table.max(axis=0))

    @cached_property
    def _codes(self) -> tuple[Indexes, Indexes]:
        """The rows as single numbers, ascending, and the place of each."""
        codes = np.ravel_multi_index(tuple(self.table.T), self._spread)
        order = np.argsort(codes)
        return codes[order], order

    def find(self, columns: Sequence[Indexes]) -> Indexes:
        """The places of many rows, each of which must be there; one array per axis."""
        codes, order = self._codes
        found = np.searchsorted(codes, np.ravel_multi_index(tuple(columns), self._spread))
        return np.asarray(order[found], dtype=np.intp)

    @cached_property
    def places(self) -> dict[tuple[int, ...], int]:
        return {tuple(row): place for place, row in enumerate(self.table.tolist())}


@dataclass(frozen=True, eq=False, slots=True)
class _View:
    """A mask beside the states: its memory, where it starts, and its strides."""

    memory: Bools
    offset: int
    strides: tuple[int, ...]


@dataclass(frozen=True, eq=False, slots=True)
class Operation:
    """All states at ``source`` (where the masks hold) lead to the states at each of ``targets``.

    Every offset is the start of a slice of the flat array, all of one shape and with the same
    strides. Several sources lead to the same targets; each has its own masks. ``words``: eight
    states are taken at a time, as one integer; there are no masks then.
    """

    shape: tuple[int, ...]
    strides: tuple[int, ...]
    words: bool
    sources: tuple[tuple[int, tuple[_View, ...]], ...]
    targets: tuple[int, ...]

    @property
    def leaving(self) -> tuple[int, ...]:
        """The sources that do not merely lead to themselves, by number."""
        return tuple(
            number for number, (source, _) in enumerate(self.sources) if self.targets != (source,)
        )

    def slice(self, states: Bools, offset: int) -> Bools:
        """A view; of integers if the operation takes words, for bitwise use alike."""
        kind = np.uint64 if self.words else np.bool_
        return np.ndarray(self.shape, kind, states, offset, self.strides)

    def source(self, states: Bools, number: int) -> Bools:
        """The states of one source where its masks hold; a view if there is no mask."""
        offset, masks = self.sources[number]
        found = self.slice(states, offset)
        for mask in masks:
            found = found & self.mask(mask)
        return found

    def mask(self, view: _View) -> Bools:
        return np.ndarray(self.shape, np.bool_, view.memory, view.offset, view.strides)


@dataclass(frozen=True, eq=False, slots=True)
class _Grid:
    """A factor over dimensions: its array, contiguous, one axis per dimension."""

    dims: tuple[int, ...]
    memory: Bools


class Layout:
    """Where each state of a plant lies, and operations for its moves."""

    def __init__(self, plant: Plant, dims: Sequence[Dim]) -> None:
        self.plant = plant
        self.dims = tuple(dims)
        sizes = [dim.size for dim in self.dims]
        self.strides = tuple(prod(sizes[i + 1 :]) for i in range(len(sizes)))
        self.size = prod(sizes)
        self.home = {
            axis: (number, column)
            for number, dim in enumerate(self.dims)
            for column, axis in enumerate(dim.axes)
        }
        self._grids: dict[int, tuple[Factor, _Grid]] = {}

    @classmethod
    def plain(cls, plant: Plant) -> Layout:
        """One dimension per axis."""
        return cls(
            plant,
            [
                Dim((number,), np.arange(axis.size).reshape(-1, 1))
                for number, axis in enumerate(plant.axes)
            ],
        )

    # --- states

    def index(self, state: PlantState) -> int | None:
        """The place of a state; None if the layout leaves it out as unreachable."""
        offset = 0
        for dim, stride in zip(self.dims, self.strides, strict=True):
            place = dim.places.get(tuple(state[axis] for axis in dim.axes))
            if place is None:
                return None
            offset += place * stride
        return offset

    def state(self, index: int) -> PlantState:
        values = [0] * len(self.plant.axes)
        for dim, stride in zip(self.dims, self.strides, strict=True):
            row = dim.table[index // stride % dim.size]
            for axis, value in zip(dim.axes, row.tolist(), strict=True):
                values[axis] = value
        return tuple(values)

    def axis_values(self, axis: int) -> tuple[int, Indexes]:
        """The dimension of an axis, and the axis's value at each place of that dimension."""
        dim, column = self.home[axis]
        return dim, self.dims[dim].table[:, column]

    # --- conditions

    def regions(self, condition: Condition) -> list[Operation]:
        """The states of a condition, as operations that lead nowhere."""
        found = self._condition(condition)
        return [] if found is None else self._operations(*found, {}, lead=False)

    def _condition(self, condition: Condition) -> tuple[dict[int, Bools], list[_Grid]] | None:
        allowed: dict[int, Bools] = {}
        for axis, values in condition.allowed.items():
            dim, own = self.axis_values(axis)
            here = values[own]
            allowed[dim] = allowed[dim] & here if dim in allowed else here
        grids: list[_Grid] = []
        for factor in condition.factors:
            grid = self.grid(factor)
            if len(grid.dims) > 1:
                grids.append(grid)
                continue
            (dim,) = grid.dims
            allowed[dim] = allowed[dim] & grid.memory if dim in allowed else grid.memory
        if not all(values.any() for values in allowed.values()):
            return None
        return allowed, grids

    def grid(self, factor: Factor) -> _Grid:
        """A factor evaluated over the dimensions of its axes, once."""
        if id(factor) not in self._grids:
            self._grids[id(factor)] = factor, self._new_grid(factor)
        return self._grids[id(factor)][1]

    def _new_grid(self, factor: Factor) -> _Grid:
        dims = tuple(sorted({self.home[axis][0] for axis in factor.axes}))
        shape = tuple(self.dims[dim].size for dim in dims)
        columns: dict[int, Indexes] = {}
        for axis in factor.axes:
            dim, values = self.axis_values(axis)
            columns[axis] = values.reshape([-1 if d == dim else 1 for d in dims])
        memory = np.empty(shape, np.bool_)
        # In parts: intermediate results are integers, eight times as large as the outcome.
        step = max(1, _LARGEST_GRID // max(1, prod(shape[1:])))
        for start in range(0, shape[0], step):
            part = slice(start, start + step)
            memory[part] = factor.test(
                {a: c[part] if c.shape[0] > 1 else c for a, c in columns.items()}
            )
        return _Grid(dims, memory)

    # --- moves

    def operations(self, move: Move, required: Condition | None = None) -> list[Operation]:
        """The operations of a move, under a further condition if given."""
        condition = move.condition if required is None else move.condition.both(required)
        found = None if condition is None else self._condition(condition)
        if found is None:
            return []
        allowed, grids = found
        by_dim: dict[int, dict[int, Writes]] = {}
        for axis, writes in move.writes.items():
            by_dim.setdefault(self.home[axis][0], {})[axis] = writes
        rectangles = {
            dim: self._rectangles(dim, writes, allowed.pop(dim, None))
            for dim, writes in by_dim.items()
        }
        return self._operations(allowed, grids, rectangles, lead=True)

    def _rectangles(
        self, number: int, writes: dict[int, Writes], allowed: Bools | None
    ) -> list[tuple[list[int], list[int]]]:
        """Rectangles over the places of a dimension.

        Places that the dimension leaves out belong to states that are never reached.
        """
        dim = self.dims[number]
        relations: list[dict[int, tuple[int, ...]] | None] = []
        for axis in dim.axes:
            rectangles = writes.get(axis)
            relations.append(
                None
                if rectangles is None
                else {value: new for old, new in rectangles for value in old}
            )
        images: dict[tuple[int, ...], list[int]] = {}
        for place, row in enumerate(dim.table.tolist()):
            if allowed is not None and not allowed[place]:
                continue
            choices = [
                (value,) if relation is None else relation.get(value, ())
                for value, relation in zip(row, relations, strict=True)
            ]
            image = tuple(p for new in product(*choices) if (p := dim.places.get(new)) is not None)
            if image:
                images.setdefault(image, []).append(place)
        return [(old, list(new)) for new, old in images.items()]

    def _operations(
        self,
        allowed: dict[int, Bools],
        grids: list[_Grid],
        rectangles: dict[int, list[tuple[list[int], list[int]]]],
        lead: bool,
    ) -> list[Operation]:
        found: list[Operation] = []
        read = [
            [(dim, run) for run in _runs(np.flatnonzero(values))]
            for dim, values in allowed.items()
            if not values.all()
        ]
        written = [[(dim, one) for one in each] for dim, each in rectangles.items()]
        for runs in product(*read):
            for ones in product(*written):
                found.extend(self._operation(dict(runs), dict(ones), grids, lead))
        return found

    def _operation(
        self,
        runs: dict[int, tuple[int, int, int]],
        ones: dict[int, tuple[list[int], list[int]]],
        grids: list[_Grid],
        lead: bool,
    ) -> Iterator[Operation]:
        """One rectangle of each written dimension, one run of each that is only read."""
        offset, shape, strides = 0, [], []
        for number, (dim, stride) in enumerate(zip(self.dims, self.strides, strict=True)):
            if number in ones:
                continue
            start, count, step = runs.get(number, (0, dim.size, 1))
            offset += start * stride
            shape.append(count)
            strides.append(step * stride)
        kept = [number for number in range(len(self.dims)) if number not in ones]
        written = list(ones)
        sources: list[tuple[int, list[tuple[Bools, int, list[int]]]]] = []
        for places in product(*(ones[dim][0] for dim in written)):
            at = dict(zip(written, places, strict=True))
            masks = [self._mask(grid, runs, at, kept) for grid in grids]
            sources.append((offset + self._shift(at), masks))
        targets = [
            offset + self._shift(dict(zip(written, places, strict=True)))
            for places in product(*(ones[dim][1] for dim in written))
        ]
        yield from _split(shape, strides, sources, targets if lead else [])

    def _shift(self, at: dict[int, int]) -> int:
        return sum(place * self.strides[dim] for dim, place in at.items())

    def _mask(
        self,
        grid: _Grid,
        runs: dict[int, tuple[int, int, int]],
        at: dict[int, int],
        kept: list[int],
    ) -> tuple[Bools, int, list[int]]:
        offset = 0
        strides = dict.fromkeys(kept, 0)
        for dim, stride in zip(grid.dims, grid.memory.strides, strict=True):
            if dim in at:
                offset += at[dim] * stride
                continue
            start, _, step = runs.get(dim, (0, 0, 1))
            offset += start * stride
            strides[dim] = step * stride
        return grid.memory, offset, list(strides.values())


def _runs(places: Indexes) -> list[tuple[int, int, int]]:
    """Ascending places as runs of equal steps: (start, count, step)."""
    values = places.tolist()
    found: list[tuple[int, int, int]] = []
    position = 0
    while position < len(values):
        end = position + 1
        step = values[end] - values[position] if end < len(values) else 1
        while end < len(values) and values[end] - values[end - 1] == step:
            end += 1
        found.append((values[position], end - position, step))
        position = end
    return found


def _split(
    shape: list[int],
    strides: list[int],
    sources: list[tuple[int, list[tuple[Bools, int, list[int]]]]],
    targets: list[int],
    words: bool | None = None,
) -> Iterator[Operation]:
    """One operation, or several where it has too many dimensions or too many states at once."""
    mask_strides = [m for _, masks in sources for _, _, m in masks]
    sizes, merged = _merge(shape, [strides, *mask_strides])
    if words is None:
        places = [*targets, *(at for at, _ in sources)]
        words = bool(targets) and not mask_strides and _in_words(sizes, merged[0], places)
        if words:
            sizes, merged = _merge([*sizes[:-1], sizes[-1] // 8], [[*merged[0][:-1], 8]])
    cut = None
    if len(sizes) > _MOST_DIMENSIONS:
        cut = min(range(len(sizes)), key=lambda i: sizes[i]), 1
    elif prod(sizes) > _LARGEST_STEP and sizes:
        cut = 0, max(1, sizes[0] * _LARGEST_STEP // prod(sizes))
    elif sizes and sizes[-1] < _SHORT and prod(sizes[:-1]) >= _WORTH_UNROLLING * sizes[-1]:
        cut = len(sizes) - 1, 1
    if cut is None or sizes[cut[0]] <= cut[1]:
        rest = iter(merged[1:])
        yield Operation(
            tuple(sizes),
            tuple(merged[0]),
            words,
            tuple(
                (
                    offset,
                    tuple(_View(memory, start, tuple(next(rest))) for memory, start, _ in masks),
                )
                for offset, masks in sources
            ),
            tuple(targets),
        )
        return
    dim, length = cut
    for start in range(0, sizes[dim], length):
        part = list(sizes)
        part[dim] = min(length, sizes[dim] - start)
        shift = start * merged[0][dim]
        rest = iter(merged[1:])
        moved = []
        for offset, masks in sources:
            views = []
            for memory, at, _ in masks:
                own = next(rest)
                views.append((memory, at + start * own[dim], list(own)))
            moved.append((offset + shift, views))
        yield from _split(part, list(merged[0]), moved, [t + shift for t in targets], words)


def _in_words(sizes: Sequence[int], strides: Sequence[int], places: Iterable[int]) -> bool:
    """Whether eight neighbouring states can be taken as one integer throughout."""
    return (
        bool(sizes)
        and strides[-1] == 1
        and sizes[-1] % 8 == 0
        and all(stride % 8 == 0 for stride in strides[:-1])
        and all(place % 8 == 0 for place in places)
    )


def _merge(shape: Iterable[int], strides: list[list[int]]) -> tuple[list[int], list[list[int]]]:
    """Neighbouring dimensions in one where all strides allow it; dimensions of size 1 vanish."""
    sizes: list[int] = []
    merged: list[list[int]] = [[] for _ in strides]
    for number, size in enumerate(shape):
        if size == 1:
            continue
        steps = [each[number] for each in strides]
        if sizes and all(m[-1] == step * size for m, step in zip(merged, steps, strict=True)):
            sizes[-1] *= size
            for each, step in zip(merged, steps, strict=True):
                each[-1] = step
        else:
            sizes.append(size)
            for each, step in zip(merged, steps, strict=True):
                each.append(step)
    return sizes, merged
