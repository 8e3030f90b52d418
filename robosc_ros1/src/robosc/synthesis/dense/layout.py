"""States as bits of one array, and the rules of a plant as operations on it.

The array has one dimension (:class:`Dim`) per state variable, or per group of state variables that
depend on each other: such a group is projected to one dimension that has only the combinations that
can occur. Some short dimensions, with a product of at most 64, are *packed*: their combinations are
the bits of a word. All others are dimensions of an array of words. So a set of states takes little
more than a bit per state, and an operation on one word moves up to 64 states.

The *place* of a state is the number of its bit in the array.
"""

from __future__ import annotations

from bisect import bisect_right
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from itertools import product
from math import prod

import numpy as np

from robosc.plant.automaton import Plant, PlantState
from robosc.synthesis.dense.bitset import BITS, WORD, Bitset, add, pack, unpack
from robosc.synthesis.dense.dimensions import Dim
from robosc.synthesis.dense.merging import Condition, Factor, TransitionRule, Writes
from robosc.synthesis.dense.operations import (
    MaskView,
    Operation,
    Shape,
    ShiftMask,
    SourceSlice,
    operations,
)
from robosc.synthesis.vectorised import Bools, Indexes

_LARGEST_GRID = 2**22


@dataclass(frozen=True, eq=False, slots=True)
class _Grid:
    """A factor as bit masks; ``memory`` has the dimensions ``dims`` of the array that it reads."""

    dims: tuple[int, ...]
    memory: Bitset


@dataclass(frozen=True, eq=False, slots=True)
class _Where:
    """A condition in terms of the array: positions per dimension, bits of a word, and grids."""

    allowed: dict[int, Bools]
    bits: Bools
    grids: list[_Grid]


class Layout:
    """The array positions of a plant's states, and the operations of its rules.

    ``size`` is the number of combinations, ``words`` the number of words of a set of states.
    """

    def __init__(self, plant: Plant, dims: Sequence[Dim]) -> None:
        self.plant = plant
        self.dims = tuple(dims)
        self.size = prod(dim.size for dim in self.dims)
        self.home = {
            variable: (number, column)
            for number, dim in enumerate(self.dims)
            for column, variable in enumerate(dim.variables)
        }
        self._packed = _packed([dim.size for dim in self.dims])
        self._outer = tuple(n for n in range(len(self.dims)) if n not in self._packed)
        self.bits = prod(self.dims[n].size for n in self._packed)
        self.words = prod(self.dims[n].size for n in self._outer)
        self.strides = self._strides()
        numbers = np.arange(self.bits)
        self._positions = {n: numbers // self.strides[n] % self.dims[n].size for n in self._packed}
        """Per packed dimension, its position at each bit."""
        self._grids: dict[Factor, _Grid] = {}

    @classmethod
    def plain(cls, plant: Plant) -> Layout:
        """Return the layout with one dimension per state variable."""
        return cls(
            plant,
            [
                Dim((number,), np.arange(variable.size).reshape(-1, 1))
                for number, variable in enumerate(plant.variables)
            ],
        )

    def _strides(self) -> tuple[int, ...]:
        """Return, per dimension, the distance of its positions in bits."""
        strides = [0] * len(self.dims)
        for numbers, stride in ((self._packed, 1), (self._outer, BITS)):
            for number in reversed(numbers):
                strides[number] = stride
                stride *= self.dims[number].size
        return tuple(strides)

    # --- states

    def nothing(self) -> Bitset:
        """Return the empty set, as a new array."""
        return np.zeros(self.words, WORD)

    def everything(self) -> Bitset:
        """Return all combinations, reachable or not, as a new array."""
        return np.full(self.words, self._every_bit, WORD)

    @property
    def _every_bit(self) -> int:
        return (1 << self.bits) - 1

    def of(self, places: Indexes) -> Bitset:
        """Return the set of states at some places, which are ascending, as a new array."""
        states = self.nothing()
        add(states, places)
        return states

    def index(self, state: PlantState) -> int | None:
        """Return the place of a state; None if the layout leaves it out as unreachable."""
        place = 0
        for dim, stride in zip(self.dims, self.strides, strict=True):
            position = dim.positions.get(tuple(state[variable] for variable in dim.variables))
            if position is None:
                return None
            place += position * stride
        return place

    def starts(self) -> Indexes:
        """Return the places of the initial states, ascending."""
        places = np.zeros(1, dtype=np.intp)
        for dim, stride in zip(self.dims, self.strides, strict=True):
            starts = product(
                *(self.plant.variables[variable].start_indexes for variable in dim.variables)
            )
            positions = np.array([dim.positions[row] for row in starts], dtype=np.intp)
            places = (places[:, None] + positions * stride).reshape(-1)
        return np.sort(places)

    def state(self, place: int) -> PlantState:
        """Return the state at a place."""
        columns = self.columns(np.array([place]))
        return tuple(int(columns[variable][0]) for variable in range(len(columns)))

    def columns(self, places: Indexes) -> dict[int, Indexes]:
        """Return the values of each state variable in the states at some places."""
        columns: dict[int, Indexes] = {}
        for number, dim in enumerate(self.dims):
            rows = dim.table[self.position(number, places)]
            for column, variable in enumerate(dim.variables):
                columns[variable] = rows[:, column]
        return columns

    def position(self, number: int, places: Indexes) -> Indexes:
        """Return the positions in one dimension of states at some places."""
        within = places % BITS if number in self._packed else places
        return np.asarray(within // self.strides[number] % self.dims[number].size)

    @property
    def order(self) -> tuple[Dim, ...]:
        """The dimensions in memory order, packed ones last."""
        return tuple(self.dims[number] for number in (*self._outer, *self._packed))

    def flags(self, states: Bitset) -> Bools:
        """Return a set as flat booleans, with the dimensions in ``order``."""
        return unpack(states, self.bits).reshape(-1)

    def _values(self, variable: int) -> tuple[int, Indexes]:
        """Return the dimension of a state variable, and its value at each position there."""
        dim, column = self.home[variable]
        return dim, self.dims[dim].table[:, column]

    # --- conditions

    def regions(self, condition: Condition) -> list[Operation]:
        """Return the states of a condition, as operations without targets."""
        where = self._where(condition)
        if where is None:
            return []
        shift_masks = [ShiftMask(np.uint64(pack(where.bits)), 0)]
        return self._operations(where, {}, shift_masks, lead=False)

    def _where(self, condition: Condition) -> _Where | None:
        where = _Where({}, np.ones(self.bits, np.bool_), [])
        for variable, values in condition.allowed.items():
            dim, own = self._values(variable)
            self._restrict(where, dim, values[own])
        for factor in condition.factors:
            grid = self._grid(factor)
            if grid.dims:
                where.grids.append(grid)
            else:
                where.bits[...] &= unpack(grid.memory, self.bits)
        if not where.bits.any() or not all(values.any() for values in where.allowed.values()):
            return None
        return where

    def _restrict(self, where: _Where, dim: int, positions: Bools) -> None:
        if dim in self._positions:
            where.bits[...] &= positions[self._positions[dim]]
        elif dim in where.allowed:
            where.allowed[dim] = where.allowed[dim] & positions
        else:
            where.allowed[dim] = positions

    def _grid(self, factor: Factor) -> _Grid:
        """Return the grid of a factor, evaluated once."""
        if factor not in self._grids:
            self._grids[factor] = self._new_grid(factor)
        return self._grids[factor]

    def _new_grid(self, factor: Factor) -> _Grid:
        """Evaluate a factor in chunks: intermediate results are integer arrays and may be large."""
        read = {self.home[variable][0] for variable in factor.variables}
        dims = tuple(sorted(read.difference(self._packed)))
        shape = tuple(self.dims[dim].size for dim in dims)
        columns: dict[int, Indexes] = {}
        for variable in factor.variables:
            dim, values = self._values(variable)
            if dim in self._positions:
                columns[variable] = values[self._positions[dim]].reshape([1] * len(dims) + [-1])
            else:
                columns[variable] = values.reshape([-1 if d == dim else 1 for d in dims] + [1])
        memory = np.empty(shape, WORD)
        if not dims:
            memory[()] = self._masks(factor, columns, shape)
            return _Grid(dims, memory)
        step = max(1, _LARGEST_GRID // (prod(shape[1:]) * BITS))
        for start in range(0, shape[0], step):
            part = slice(start, start + step)
            some = {a: c[part] if c.shape[0] > 1 else c for a, c in columns.items()}
            memory[part] = self._masks(factor, some, memory[part].shape)
        return _Grid(dims, memory)

    def _masks(
        self, factor: Factor, columns: Mapping[int, Indexes], shape: tuple[int, ...]
    ) -> Bitset:
        return pack(np.broadcast_to(factor.test(columns), (*shape, self.bits)))

    # --- rules

    def operations(
        self, rule: TransitionRule, required: Condition | None = None
    ) -> list[Operation]:
        """Return the operations of a rule, under a further condition if given."""
        condition = rule.condition if required is None else rule.condition.both(required)
        where = None if condition is None else self._where(condition)
        if where is None:
            return []
        by_dim: dict[int, dict[int, Writes]] = {}
        for variable, writes in rule.writes.items():
            by_dim.setdefault(self.home[variable][0], {})[variable] = writes
        images = {dim: self.dims[dim].images(writes) for dim, writes in by_dim.items()}
        rectangles = {
            dim: _rectangles(found, where.allowed.pop(dim, None))
            for dim, found in images.items()
            if dim not in self._positions
        }
        shift_masks = self._shift_masks(
            where.bits, {dim: found for dim, found in images.items() if dim in self._positions}
        )
        return self._operations(where, rectangles, shift_masks, lead=True) if shift_masks else []

    def _shift_masks(
        self, bits: Bools, images: dict[int, list[tuple[int, ...]]]
    ) -> list[ShiftMask]:
        """Return how the bits of a word move when packed dimensions are written."""
        masks: dict[int, int] = {}
        for bit in np.flatnonzero(bits).tolist():
            moves = []
            for dim, found in images.items():
                old = int(self._positions[dim][bit])
                moves.append([(new - old) * self.strides[dim] for new in found[old]])
            for shifts in product(*moves):
                masks[sum(shifts)] = masks.get(sum(shifts), 0) | 1 << bit
        return [ShiftMask(np.uint64(mask), shift) for shift, mask in sorted(masks.items())]

    def _operations(
        self,
        where: _Where,
        rectangles: dict[int, list[tuple[list[int], list[int]]]],
        shift_masks: Sequence[ShiftMask],
        lead: bool,
    ) -> list[Operation]:
        operations: list[Operation] = []
        read = [
            [(dim, run) for run in _runs(np.flatnonzero(values))]
            for dim, values in where.allowed.items()
            if not values.all()
        ]
        written = [[(dim, one) for one in each] for dim, each in rectangles.items()]
        for runs in product(*read):
            for ones in product(*written):
                operations.extend(
                    self._operation(dict(runs), dict(ones), where.grids, shift_masks, lead)
                )
        return operations

    def _operation(
        self,
        runs: dict[int, tuple[int, int, int]],
        ones: dict[int, tuple[list[int], list[int]]],
        grids: Iterable[_Grid],
        shift_masks: Sequence[ShiftMask],
        lead: bool,
    ) -> Iterator[Operation]:
        """Yield the operations of one rectangle per written and one run per read dimension."""
        offset = 0
        kept: dict[int, tuple[int, int]] = {}
        for number in self._outer:
            if number not in ones:
                start, length, step = runs.get(number, (0, self.dims[number].size, 1))
                offset += start * self.strides[number] // 8
                kept[number] = length, step * self.strides[number] // 8
        written = list(ones)
        sources = []
        for positions in product(*(ones[dim][0] for dim in written)):
            at = dict(zip(written, positions, strict=True))
            masks = tuple(_view(grid, runs, at, list(kept)) for grid in grids)
            sources.append(SourceSlice(offset + self._shift(at), masks))
        targets = [
            offset + self._shift(dict(zip(written, positions, strict=True)))
            for positions in product(*(ones[dim][1] for dim in written))
        ]
        shape = Shape([n for n, _ in kept.values()], [s for _, s in kept.values()])
        return operations(shape, sources, targets if lead else [], shift_masks, self._every_bit)

    def _shift(self, at: dict[int, int]) -> int:
        """Return the offset of some positions in the array, in bytes."""
        return sum(position * self.strides[dim] // 8 for dim, position in at.items())


def _packed(sizes: Sequence[int]) -> tuple[int, ...]:
    """Return the dimensions to pack: those whose product fills a word best."""
    best: dict[int, tuple[int, ...]] = {1: ()}
    for number, size in enumerate(sizes):
        for filled, chosen in list(best.items()):
            if filled * size <= BITS:
                best.setdefault(filled * size, (*chosen, number))
    return best[max(best)]


def _rectangles(
    images: Sequence[tuple[int, ...]], allowed: Bools | None
) -> list[tuple[list[int], list[int]]]:
    """Return positions with equal images as (positions, image)."""
    by_image: dict[tuple[int, ...], list[int]] = {}
    for position, image in enumerate(images):
        if image and (allowed is None or allowed[position]):
            by_image.setdefault(image, []).append(position)
    return [(old, list(new)) for new, old in by_image.items()]


def _runs(positions: Indexes) -> list[tuple[int, int, int]]:
    """Return ascending positions as arithmetic progressions: (start, length, step)."""
    steps = np.diff(positions)
    ends = [*(np.flatnonzero(steps[1:] != steps[:-1]) + 1).tolist(), len(steps)]
    runs: list[tuple[int, int, int]] = []
    at = 0
    while at < len(positions):
        end = ends[bisect_right(ends, at, hi=len(ends) - 1)]
        step = int(steps[at]) if at < len(steps) else 1
        runs.append((int(positions[at]), end - at + 1, step))
        at = end + 1
    return runs


def _view(
    grid: _Grid, runs: dict[int, tuple[int, int, int]], at: dict[int, int], kept: Sequence[int]
) -> MaskView:
    offset = 0
    strides = dict.fromkeys(kept, 0)
    for dim, stride in zip(grid.dims, grid.memory.strides, strict=True):
        if dim in at:
            offset += at[dim] * stride
            continue
        start, _, step = runs.get(dim, (0, 0, 1))
        offset += start * stride
        strides[dim] = step * stride
    return MaskView(grid.memory, offset, tuple(strides.values()))
