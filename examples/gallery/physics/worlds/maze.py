"""A maze without loops, of cells; the way out is somewhere on its border."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

from physics.rover import ODOMETRY, Laser, odometry
from physics.rover_world import RoverWorld, sees, wall
from physics.tasks import Turn
from physics.world import Sample, Task

__all__ = ["Maze"]

SIDE = 3
"""Cells."""
CELL = 0.8
"""Metres."""

Cell = tuple[int, int]


class Maze(RoverWorld):
    seconds = 60.0
    sensors = {"/scan": Laser.TYPE, "/odom": ODOMETRY}
    commands = {"/cmd_vel": "geometry_msgs/Twist", "/alive": "std_msgs/Empty"}
    actions = {"/turn": "gallery_msgs/Turn"}
    view = {"distance": 4.6, "elevation": -65.0, "azimuth": 90.0}

    def things(self) -> str:
        passages = self._dig()
        walls = []
        for x in range(SIDE):
            for y in range(SIDE):
                for dx, dy in ((1, 0), (0, 1), (-1, 0), (0, -1)):
                    there = (x + dx, y + dy)
                    outside = not (0 <= there[0] < SIDE and 0 <= there[1] < SIDE)
                    closed = frozenset({(x, y), there}) not in passages
                    if closed and (outside or (dx, dy) in ((1, 0), (0, 1))):
                        walls.append(self._wall((x, y), dx, dy))
        self.start = (*self._middle((0, SIDE - 1)), -1.5708 + self.random.uniform(-0.1, 0.1))
        return "".join(wall(str(i), *ends) for i, ends in enumerate(walls))

    def _dig(self) -> set[frozenset[Cell]]:
        """Return which cells are joined: a tree, and an exit at the right."""
        passages = {frozenset({(SIDE - 1, 0), (SIDE, 0)})}
        seen, path = {(0, 0)}, [(0, 0)]
        while path:
            x, y = path[-1]
            around = [
                (x + dx, y + dy)
                for dx, dy in ((1, 0), (0, 1), (-1, 0), (0, -1))
                if 0 <= x + dx < SIDE and 0 <= y + dy < SIDE and (x + dx, y + dy) not in seen
            ]
            if not around:
                path.pop()
                continue
            there = self.random.choice(around)
            passages.add(frozenset({(x, y), there}))
            seen.add(there)
            path.append(there)
        return passages

    def _middle(self, at: Cell) -> tuple[float, float]:
        return (at[0] - (SIDE - 1) / 2) * CELL, (at[1] - (SIDE - 1) / 2) * CELL

    def _wall(self, at: Cell, dx: int, dy: int) -> tuple[tuple[float, float], tuple[float, float]]:
        x, y = self._middle(at)
        x, y = x + dx * CELL / 2, y + dy * CELL / 2
        return (x - dy * CELL / 2, y - dx * CELL / 2), (x + dy * CELL / 2, y + dx * CELL / 2)

    def sense(self) -> Iterator[Sample]:
        yield "/scan", Laser.TYPE, self.laser.scan()
        yield "/odom", ODOMETRY, odometry(self.rover)

    def judge(self, speed: float, turn: float) -> None:
        if speed or turn:
            self.observer.judge("moves only if it sees", lambda m: sees(m, *self.sensors))
            self.observer.judge("does not disturb a turn", lambda m: "/turn" not in m["busy"])

    def begin(self, action: str, request: Any) -> Task:
        self.observer.judge("turns only if it sees", lambda m: sees(m, *self.sensors))
        return Turn(self.rover, request.angle)

    def succeeded(self) -> bool:
        return self.rover.position[0] > SIDE * CELL / 2 + 0.15
