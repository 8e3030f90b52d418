"""Which tests a run takes.

``quick``
    The inner loop: nothing that is marked ``slow``, and of a function with many or long cases as
    many as take little (``costs.csv``).
``usual``
    Whether it works on this machine: everything that is not slow, and of what is marked ``once``
    too, one case each. Of two functions of one name in ``ros1`` and ``ros2``, which test the same
    behaviour, one of both.
``rest``
    What ``usual`` leaves out.
``all``
    Everything.

What is taken depends on nothing but the names of the tests, so it is the same in each run.
"""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Callable, Hashable, Sequence
from zlib import crc32

import costs
import pytest

__all__ = ["SIZES", "seconds_of_groups", "take"]

SIZES = ("quick", "usual", "rest", "all")
OF_ALL_CASES = 0.03
"""Seconds of processor that a function may take in a quick run, or ..."""
OF_ONE_CASE = 0.1
"""... those of its only case there."""
SIDES = {"ros1", "ros2"}


def take(size: str, items: list[pytest.Item]) -> list[pytest.Item]:
    """Return those tests that belong to a size, in their order."""
    if size == "all":
        return items
    taken = set(quick(items) if size == "quick" else usual(items))
    return [item for item in items if (item in taken) != (size == "rest")]


def quick(items: Sequence[pytest.Item]) -> list[pytest.Item]:
    known = costs.read(costs.KEPT)
    functions: dict[str, list[pytest.Item]] = defaultdict(list)
    for item in items:
        if not item.get_closest_marker("slow"):
            functions[costs.function_of(item.nodeid)].append(item)
    taken = []
    for function, cases in functions.items():
        number = len(cases)
        if (cost := known.get(function)) and cost.processor > OF_ALL_CASES:
            each = cost.processor / cost.cases
            number = max(int(OF_ALL_CASES / each), int(each <= OF_ONE_CASE))
        taken += sorted(cases, key=rank)[:number]
    return taken


def usual(items: Sequence[pytest.Item]) -> list[pytest.Item]:
    behaviours: dict[Hashable, list[pytest.Item]] = defaultdict(list)
    for item in items:
        if item.get_closest_marker("once"):
            behaviours[behaviour(item)].append(item)
    taken = [item for item in items if not item.get_closest_marker("slow")]
    for cases in behaviours.values():
        sides = sorted({item.path.parent.name for item in cases})
        (name,) = {costs.function_of(item.nodeid).rpartition("::")[2] for item in cases}
        side = sides[crc32(name.encode()) % len(sides)]
        taken.append(min((c for c in cases if c.path.parent.name == side), key=rank))
    return taken


def behaviour(item: pytest.Item) -> Hashable:
    """What a function tests: the same as its twin with the other ROS."""
    function = costs.function_of(item.nodeid)
    folder = item.path.parent.name
    return function.rpartition("::")[2] if folder in SIDES else function


def rank(item: pytest.Item) -> int:
    return crc32(costs.function_of(item.nodeid).encode() + item.name.encode())


def seconds_of_groups(
    items: Sequence[pytest.Item], group_of: Callable[[pytest.Item], str]
) -> dict[str, float]:
    """Return how long the tests take that run in one process, as far as it is known."""
    known = costs.read(costs.KEPT)
    seconds: dict[str, float] = defaultdict(float)
    for item in items:
        seconds[group_of(item)] += costs.seconds_of(item.nodeid, known)
    return seconds
