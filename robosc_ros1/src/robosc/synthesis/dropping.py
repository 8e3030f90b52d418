"""What distinguishes two sets: greedy elimination and greedy selection, in few attempts."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from math import log2
from typing import TypeVar

__all__ = ["drop", "select"]

_Item = TypeVar("_Item")
_Left = TypeVar("_Left")

_FIRST = 4
"""After so many items it shows whether a few more will do."""


def drop(
    items: Sequence[_Item], left: _Left, without: Callable[[_Left, Sequence[_Item]], _Left | None]
) -> _Left:
    """What is left when each item in turn is dropped if it can be.

    ``without`` drops some items at once, or gives None where they cannot all go. Where they can,
    each of them can go alone, so halves are tried before single items: of n items of which k must
    stay it takes some k log n attempts instead of n.
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
    """Up to ``most`` of ``count`` items that leave none of ``total`` states confused.

    ``confused`` gives, for some chosen items, how many states are still confused with each further
    one. The best is chosen each time. None if it takes more items, or is bound to: at the rate of
    the first ones.
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
