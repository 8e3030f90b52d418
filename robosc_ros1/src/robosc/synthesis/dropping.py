"""Which items are needed to distinguish two sets: greedy elimination and greedy selection."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from math import log2
from typing import TypeVar

__all__ = ["drop", "select"]

_Item = TypeVar("_Item")
_Left = TypeVar("_Left")

_FIRST = 4
"""Items after which the rate of progress is extrapolated."""


def drop(
    items: Sequence[_Item], left: _Left, without: Callable[[_Left, Sequence[_Item]], _Left | None]
) -> _Left:
    """Return what is left after each item in turn is dropped if it can be.

    ``without`` drops some items at once, or returns None if they cannot all be dropped. If they
    can, each of them can be dropped alone, so halves are tried before single items: of n items of
    which k must stay, this takes some k log n attempts instead of n.
    """
    if not items:
        return left
    found = without(left, items)
    if found is not None:
        return found
    if len(items) == 1:
        return left
    half = len(items) // 2
    return drop(items[half:], drop(items[:half], left, without), without)


def select(
    count: int, total: int, most: int, confused: Callable[[Sequence[int]], Mapping[int, int]]
) -> list[int] | None:
    """Return up to ``most`` of ``count`` items that leave none of ``total`` states confused.

    ``confused`` returns, given the chosen items, how many states stay confused with each further
    item added. The best is chosen each time. None if it takes more than ``most`` items, or would
    at the rate of the first ones.
    """
    chosen: list[int] = []
    while len(chosen) < min(most, count):
        left = confused(chosen)
        best = min(left, key=lambda item: left[item])
        chosen.append(best)
        if not left[best]:
            return chosen
        steps = len(chosen)
        if steps >= _FIRST:
            rate = (log2(total) - log2(left[best])) / steps
            if log2(left[best]) >= rate * (most - steps):
                return None
    return None
