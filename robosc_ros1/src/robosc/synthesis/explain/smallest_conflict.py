"""Smallest sets of requirements that conflict: each of them is needed for what they rule out.

Fewer requirements forbid less, so that "there is no controller" and "this command never happens"
are kept by each larger set of requirements. Such a set is found with few syntheses by halving
(Junker, "QuickXplain", AAAI 2004).
"""

from __future__ import annotations

from collections.abc import Callable, Sequence

Fails = Callable[[frozenset[int]], bool]
"""Whether a set of requirements, by number, rules out what is to be explained."""


def smallest_conflict(requirements: Sequence[int], fails: Fails) -> tuple[int, ...]:
    """Return a subset of which no proper subset fails, in order; all requirements together do."""
    if fails(frozenset()):
        return ()
    return tuple(sorted(_needed(frozenset(), False, requirements, fails)))


def _needed(
    kept: frozenset[int], grown: bool, requirements: Sequence[int], fails: Fails
) -> frozenset[int]:
    """Return those of ``requirements`` that are needed beside ``kept``.

    ``grown``: ``kept`` has more than when it was last asked for alone.
    """
    if grown and fails(kept):
        return frozenset()
    if len(requirements) == 1:
        return frozenset(requirements)
    first, second = requirements[: len(requirements) // 2], requirements[len(requirements) // 2 :]
    later = _needed(kept | frozenset(first), True, second, fails)
    earlier = _needed(kept | later, bool(later), first, fails)
    return earlier | later
