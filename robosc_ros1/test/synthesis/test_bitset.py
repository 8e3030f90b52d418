"""Sets of states as bits of words."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from robosc.synthesis.dense.bitset import WORD, add, count, members, pack, places, unpack

numbers = st.lists(st.integers(0, 5 * 64 - 1), unique=True).map(sorted)


def words_of(numbers: list[int]) -> np.ndarray:
    words = np.zeros(5, WORD)
    add(words, np.array(numbers, dtype=np.intp))
    return words


@given(numbers)
def test_what_is_added_is_there_and_nothing_else(chosen: list[int]) -> None:
    words = words_of(chosen)
    assert places(words).tolist() == chosen
    assert count(words) == len(chosen)
    everything = np.arange(5 * 64)
    assert np.flatnonzero(members(words, everything)).tolist() == chosen


@given(numbers, numbers)
def test_adding_keeps_what_was_there(first: list[int], second: list[int]) -> None:
    words = words_of(first)
    add(words, np.array(second, dtype=np.intp))
    assert places(words).tolist() == sorted({*first, *second})


@pytest.mark.parametrize("bits", [1, 6, 63, 64])
def test_packing_and_back(bits: int) -> None:
    flags = np.random.default_rng(bits).random((3, 4, bits)) < 0.5
    words = pack(flags)
    assert words.shape == (3, 4)
    assert np.array_equal(unpack(words, bits), flags)
    assert count(words) == flags.sum()


@pytest.mark.parametrize("size", [0, 1, 2**15 - 1, 2**15 + 1])
def test_counting_many(size: int) -> None:
    words = np.random.default_rng(size).integers(0, 2**64, size, dtype=np.uint64)
    assert count(words) == sum(int(word).bit_count() for word in words)


def test_counting_what_is_not_contiguous() -> None:
    words = np.arange(24, dtype=np.uint64).reshape(2, 3, 4)[:, ::2, 1:3]
    assert count(words) == sum(int(word).bit_count() for word in words.ravel())
