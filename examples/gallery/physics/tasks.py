"""What the rover's action servers do: drive to a place around obstacles, turn by an angle."""

from __future__ import annotations

import heapq
import math
from collections.abc import Callable, Iterator
from typing import Any

from physics.rover import Rover, wrap
from physics.world import STEP

__all__ = ["Drive", "Place", "Turn", "way"]

Place = tuple[float, float]
GRID = 0.1
"""Metres."""
SPEED = 0.5
ARRIVED = 0.08
PATIENCE = 60.0


class Drive:
    """Drives along a way, in metres; fails if there is none."""

    def __init__(self, rover: Rover, places: list[Place]) -> None:
        self._rover, self._places = rover, places
        self._left = PATIENCE

    def step(self) -> bool | None:
        self._left -= STEP
        while self._places and self._rover.distance(*self._places[0]) < ARRIVED:
            self._places.pop(0)
            if not self._places:
                self.stop()
                return True
        if not self._places or self._left < 0.0:
            self.stop()
            return False
        turn = self._rover.bearing(*self._places[0])
        self._rover.drive(SPEED * max(0.0, math.cos(turn)) ** 4, 2.5 * turn)
        return None

    def feedback(self) -> dict[str, Any]:
        return {"distance": self._rover.distance(*self._places[-1]) if self._places else 0.0}

    def result(self) -> dict[str, Any]:
        return {}

    def stop(self) -> None:
        self._rover.drive(0.0, 0.0)


class Turn:
    """Turns by an angle, in radians, to the left."""

    def __init__(self, rover: Rover, angle: float) -> None:
        self._rover = rover
        self._heading = rover.heading + angle
        self._left = PATIENCE

    def step(self) -> bool | None:
        self._left -= STEP
        rest = wrap(self._heading - self._rover.heading)
        if abs(rest) < 0.03 or self._left < 0.0:
            self.stop()
            return self._left >= 0.0
        self._rover.drive(0.0, max(-1.5, min(1.5, 4.0 * rest)))
        return None

    def feedback(self) -> dict[str, Any]:
        return {"left": wrap(self._heading - self._rover.heading)}

    def result(self) -> dict[str, Any]:
        return {}

    def stop(self) -> None:
        self._rover.drive(0.0, 0.0)


def way(begin: Place, end: Place, is_free: Callable[[Place], bool]) -> list[Place]:
    """Return places on a shortest way over a grid (A*); none if there is no way."""
    start, goal = cell(begin), cell(end)
    queue = [(0.0, 0.0, start, start)]
    came: dict[tuple[int, int], tuple[int, int]] = {}
    while queue:
        _, cost, here, before = heapq.heappop(queue)
        if here in came:
            continue
        came[here] = before
        if here == goal:
            return [*reversed([place(c) for c in trace(came, goal, start)][1:]), end]
        for there, length in neighbours(here):
            if there not in came and is_free(place(there)):
                total = cost + length
                heapq.heappush(queue, (total + math.dist(there, goal), total, there, here))
    return []


def trace(
    came: dict[tuple[int, int], tuple[int, int]], goal: tuple[int, int], start: tuple[int, int]
) -> Iterator[tuple[int, int]]:
    while goal != start:
        yield goal
        goal = came[goal]


def neighbours(here: tuple[int, int]) -> Iterator[tuple[tuple[int, int], float]]:
    for dx in (-1, 0, 1):
        for dy in (-1, 0, 1):
            if dx or dy:
                yield (here[0] + dx, here[1] + dy), math.hypot(dx, dy)


def cell(at: Place) -> tuple[int, int]:
    return round(at[0] / GRID), round(at[1] / GRID)


def place(at: tuple[int, int]) -> Place:
    return at[0] * GRID, at[1] * GRID
