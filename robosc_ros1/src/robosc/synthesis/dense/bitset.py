"""Sets of states as bits, 64 to a word."""

from __future__ import annotations

from typing import TypeAlias

import numpy as np
from numpy.typing import NDArray

from robosc.synthesis.vectorised import Bools, Indexes

BITS = 64
WORD = np.dtype("<u8")
Bitset: TypeAlias = NDArray[np.uint64]

_CHUNK = 2**15
_PAIRS = np.uint64(0x5555555555555555)
_FOURS = np.uint64(0x3333333333333333)
_EIGHTS = np.uint64(0x0F0F0F0F0F0F0F0F)
_SUM = np.uint64(0x0101010101010101)
_ONE, _TWO, _FOUR, _TOP = (np.uint64(n) for n in (1, 2, 4, 56))


def count(words: Bitset) -> int:
    """Return the number of bits that are set."""
    flat = np.ascontiguousarray(words).reshape(-1)
    return sum(_count(flat[start : start + _CHUNK]) for start in range(0, flat.size, _CHUNK))


def _count(words: Bitset) -> int:
    """Add up bits in parallel, in ever wider fields (Warren, Hacker's Delight, 5-1)."""
    found = words - ((words >> _ONE) & _PAIRS)
    found = (found & _FOURS) + ((found >> _TWO) & _FOURS)
    found = (found + (found >> _FOUR)) & _EIGHTS
    found *= _SUM
    found >>= _TOP
    return int(found.sum())


def pack(flags: Bools) -> Bitset:
    """Return booleans as words along the last axis, which has at most 64 entries."""
    padded = np.zeros((*flags.shape[:-1], BITS), np.bool_)
    padded[..., : flags.shape[-1]] = flags
    packed = np.packbits(padded, axis=-1, bitorder="little")
    return packed.view(WORD)[..., 0]


def unpack(words: Bitset, bits: int) -> Bools:
    """Return the lowest ``bits`` of each word as booleans along a new last axis."""
    flat = np.ascontiguousarray(words).view(np.uint8).reshape(*words.shape, BITS // 8)
    return np.unpackbits(flat, axis=-1, count=bits, bitorder="little").view(np.bool_)


def places(words: Bitset) -> Indexes:
    """Return the numbers of the bits that are set, ascending."""
    filled = np.flatnonzero(words)
    rows, bits = np.nonzero(unpack(words[filled], BITS))
    return np.asarray(filled[rows] * BITS + bits, dtype=np.intp)


def members(words: Bitset, numbers: Indexes) -> Bools:
    """Return which of the numbered bits are set."""
    shifts = (numbers % BITS).astype(np.uint64)
    return np.asarray((words[numbers // BITS] >> shifts) & _ONE, dtype=np.bool_)


def add(words: Bitset, numbers: Indexes) -> None:
    """Set the bits with the given numbers, which are ascending."""
    if not len(numbers):
        return
    home = numbers // BITS
    bits = _ONE << (numbers % BITS).astype(np.uint64)
    starts = np.flatnonzero(np.diff(home, prepend=-1))
    words[home[starts]] |= np.bitwise_or.reduceat(bits, starts)
