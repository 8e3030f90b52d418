"""Operations: the effect of an event on whole slices of states at once.

States are bits of 64-bit words (:mod:`robosc.synthesis.dense.layout`). An operation maps slices of
words to slices of words of the same shape, and bits within each word by pairs of a shift and a mask
of the bits that it moves.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass
from functools import reduce
from math import prod
from operator import or_

import numpy as np

from robosc.synthesis.dense.bitset import WORD, Bitset

_LARGEST_STEP = 2**16
"""Words per operation with intermediate results: these should fit into the processor's cache."""
_MOST_DIMENSIONS = 24
_SHORT = 16
"""Inner loops shorter than this cost more than their work; they are unrolled to operations."""
_WORTH_UNROLLING = 2**9


@dataclass(frozen=True, eq=False, slots=True)
class ShiftMask:
    """The bits of ``mask`` move up by ``shift`` places, or down if it is negative."""

    mask: np.uint64
    shift: int


@dataclass(frozen=True, eq=False, slots=True)
class MaskView:
    """Masks, one per word of a slice: their memory, and offset and strides in bytes."""

    memory: Bitset
    offset: int
    strides: tuple[int, ...]


@dataclass(frozen=True, eq=False, slots=True)
class SourceSlice:
    """The offset of a slice in bytes, and the masks that apply to its words."""

    offset: int
    masks: tuple[MaskView, ...]


@dataclass(frozen=True, eq=False, slots=True)
class Operation:
    """All states of each source that pass its masks lead, after the shifts, to each target.

    Offsets and strides are in bytes. ``whole``: the only shift is 0 and its mask is full.
    An operation without targets only denotes the set of states that it applies to.
    """

    shape: tuple[int, ...]
    strides: tuple[int, ...]
    sources: tuple[SourceSlice, ...]
    targets: tuple[int, ...]
    shift_masks: tuple[ShiftMask, ...]
    whole: bool

    @property
    def held(self) -> np.uint64:
        """The bits that the shifts apply to."""
        return reduce(or_, (bits.mask for bits in self.shift_masks))

    def at(self, states: Bitset, offset: int) -> Bitset:
        """Return a view of the slice at an offset."""
        return np.ndarray(self.shape, WORD, states, offset, self.strides)

    def mask(self, view: MaskView) -> Bitset:
        return np.ndarray(self.shape, WORD, view.memory, view.offset, view.strides)

    def masked(self, source: SourceSlice, words: Bitset) -> Bitset:
        """Return words restricted to the masks of a source; the same array if it has none."""
        for view in source.masks:
            words = words & self.mask(view)
        return words

    def moved(self, words: Bitset) -> Bitset:
        """Return words after the shifts; the same array if nothing changes."""
        if self.whole:
            return words
        return reduce(or_, (_shifted(words & bits.mask, bits.shift) for bits in self.shift_masks))

    def moved_back(self, words: Bitset) -> Bitset:
        """Return words before the shifts; the same array if nothing changes."""
        if self.whole:
            return words
        return reduce(or_, (_shifted(words, -bits.shift) & bits.mask for bits in self.shift_masks))

    @property
    def changing(self) -> tuple[SourceSlice, ...]:
        """The sources that lead to other states than themselves."""
        if any(shift_mask.shift for shift_mask in self.shift_masks):
            return self.sources
        return tuple(source for source in self.sources if self.targets != (source.offset,))


def _shifted(words: Bitset, shift: int) -> Bitset:
    if shift > 0:
        return np.left_shift(words, np.uint64(shift))
    return np.right_shift(words, np.uint64(-shift)) if shift else words


@dataclass(frozen=True, slots=True)
class Shape:
    """Sizes with strides in bytes, from the slowest dimension to the fastest."""

    sizes: Sequence[int]
    strides: Sequence[int]


def operations(
    shape: Shape,
    sources: Sequence[SourceSlice],
    targets: Sequence[int],
    shift_masks: Sequence[ShiftMask],
    every_bit: int,
) -> Iterator[Operation]:
    """Yield one operation, or several where that is faster or there are too many dimensions.

    ``every_bit`` is the mask of the bits that represent states.
    """
    whole = (
        len(shift_masks) == 1 and not shift_masks[0].shift and int(shift_masks[0].mask) == every_bit
    )
    yield from _split(shape, sources, targets, tuple(shift_masks), whole)


def sweep_order(found: Iterable[Operation]) -> tuple[Operation, ...]:
    """Return the operations of an event in an order in which each uses what earlier ones add.

    Those that count up are ordered from low to high, those that count down from high to low: then
    one sweep moves a counter through its whole range, instead of one step.
    """

    def place(operation: Operation) -> int:
        source = operation.sources[0].offset
        return source if max(operation.targets) >= source else -source

    return tuple(sorted(found, key=place))


def _split(
    shape: Shape,
    sources: Sequence[SourceSlice],
    targets: Sequence[int],
    shift_masks: tuple[ShiftMask, ...],
    whole: bool,
) -> Iterator[Operation]:
    views = [view for source in sources for view in source.masks]
    sizes, (strides, *of_views) = _merge(
        shape.sizes, [shape.strides, *(view.strides for view in views)]
    )

    def sources_at(position: Sequence[int]) -> tuple[SourceSlice, ...]:
        """Return the sources from a position on, with the merged strides."""
        own = iter(of_views)
        return tuple(
            SourceSlice(
                source.offset + _offset(position, strides),
                tuple(
                    MaskView(view.memory, view.offset + _offset(position, steps), steps)
                    for view, steps in zip(source.masks, own, strict=False)
                ),
            )
            for source in sources
        )

    cut = _cut(sizes, bool(views) or not whole or len(sources) > 1)
    if cut is None:
        slices = sources_at(())
        yield Operation(tuple(sizes), strides, slices, tuple(targets), shift_masks, whole)
        return
    dim, length = cut
    for start in range(0, sizes[dim], length):
        part = Shape([*sizes[:dim], min(length, sizes[dim] - start), *sizes[dim + 1 :]], strides)
        position = [0] * dim + [start]
        moved = [target + _offset(position, strides) for target in targets]
        yield from _split(part, sources_at(position), moved, shift_masks, whole)


def _offset(position: Sequence[int], strides: Sequence[int]) -> int:
    """Return the distance of a position, given for the first dimensions only, from the start."""
    return sum(at * stride for at, stride in zip(position, strides, strict=False))


def _cut(sizes: Sequence[int], intermediate: bool) -> tuple[int, int] | None:
    """Return the dimension to cut and the length of the parts; None if the shape is fine."""
    if len(sizes) > _MOST_DIMENSIONS:
        return min(range(len(sizes)), key=lambda i: sizes[i]), 1
    total = prod(sizes)
    if intermediate and total > _LARGEST_STEP:
        return 0, max(1, sizes[0] * _LARGEST_STEP // total)
    if sizes and sizes[-1] < _SHORT and total >= _WORTH_UNROLLING * sizes[-1] ** 2:
        return len(sizes) - 1, 1
    return None


def _merge(
    shape: Iterable[int], strides: Sequence[Sequence[int]]
) -> tuple[list[int], list[tuple[int, ...]]]:
    """Join neighbouring dimensions where all strides allow it; drop those of size 1."""
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
    return sizes, [tuple(each) for each in merged]
