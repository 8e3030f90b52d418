"""Which items are needed to distinguish two sets: greedy elimination."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import TypeVar

_Item = TypeVar("_Item")
_Left = TypeVar("_Left")


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
