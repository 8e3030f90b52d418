"""A line in a loop on the floor, an emergency stop, and what the camera says of the line."""

from __future__ import annotations

import math
from collections.abc import Iterator

import numpy as np

from physics.rover import Camera
from physics.rover_world import STOP, TIMEOUT, RoverWorld, sees
from physics.world import STEP, Sample

__all__ = ["LineFollower"]

POINTS = 120
WIDTH = 0.025
GOAL = 3.0
"""Metres along the line."""
ASTRAY = 0.25


class LineFollower(RoverWorld):
    seconds = 20.0
    sensors = {"/line": "std_msgs/Float32"}
    buttons = STOP
    commands = {"/cmd_vel": "geometry_msgs/Twist", "/alive": "std_msgs/Empty"}
    view = {"distance": 3.2, "elevation": -60.0, "azimuth": 90.0}

    def __init__(self, seed: int) -> None:
        super().__init__(seed)
        self._camera = Camera(self.model, self.data)
        self._driven = 0.0
        self._near = 0

    def things(self) -> str:
        first, second = (self.random.uniform(0.0, 2 * math.pi) for _ in range(2))
        self._line = []
        for i in range(POINTS):
            angle = 2 * math.pi * i / POINTS
            radius = 0.9 + 0.15 * math.cos(2 * angle + first) + 0.08 * math.cos(3 * angle + second)
            self._line.append((radius * math.cos(angle), radius * math.sin(angle)))
        turned = self.random.uniform(-0.3, 0.3)
        self.start = (*self._line[0], self._direction(0) + turned)
        return "".join(
            f'<geom type="box" pos="{x} {y} .001" size=".035 {WIDTH} .001" rgba=".05 .05 .05 1"'
            f' euler="0 0 {math.degrees(heading)}" contype="0" conaffinity="0" group="2"/>'
            for (x, y), heading in ((self._line[i], self._direction(i)) for i in range(POINTS))
        )

    def _direction(self, index: int) -> float:
        (x, y), (next_x, next_y) = self._line[index], self._line[(index + 1) % POINTS]
        return math.atan2(next_y - y, next_x - x)

    def sense(self) -> Iterator[Sample]:
        yield "/line", self.sensors["/line"], {"data": self._offset()}
        yield from self.buttons_pressed()

    def _offset(self) -> float:
        """Return where the camera sees the line: -1 right, 1 left, not a number nowhere."""
        columns = (self._camera.picture()[12:].sum(axis=2) < 200).sum(axis=0)
        if columns.sum() < 4:
            return math.nan
        middle = (len(columns) - 1) / 2
        return float((columns * (middle - np.arange(len(columns)))).sum() / columns.sum() / middle)

    def judge(self, speed: float, turn: float) -> None:
        if speed or turn:
            self.observer.judge("moves only while released", lambda m: not m["stopped"])
            self.observer.judge("moves only if it sees", lambda m: sees(m, "/line"))
        elif self.time > STEP:  # before, a silence is noticed by the clock of the machine
            self.observer.judge(
                "halts only for a reason",
                lambda m: m["stopped"] or not m.fresh("/line", TIMEOUT - 0.1),
            )

    def watch(self) -> None:
        x, y = self.rover.position
        steps = range(self._near - 5, self._near + 10)
        near = min(steps, key=lambda i: math.dist((x, y), self._line[i % POINTS]))
        self._driven += sum(
            math.dist(self._line[i % POINTS], self._line[(i + 1) % POINTS])
            for i in range(self._near, near)
        )
        self._near = near
        if math.dist((x, y), self._line[near % POINTS]) > ASTRAY:
            self.observer.violate("stays on the line")

    def succeeded(self) -> bool:
        return self._driven >= GOAL

    def close(self) -> None:
        self._camera.close()
