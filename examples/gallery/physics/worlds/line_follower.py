"""A line in a loop on the floor, an emergency stop, and what the camera says of the line."""

from __future__ import annotations

import math
from collections.abc import Iterator
from typing import Any

import numpy as np

from physics.rover import OUTSIDE, Camera, Rover, assets, body, motors
from physics.world import Sample, World

__all__ = ["LineFollower"]

POINTS = 120
WIDTH = 0.025
GOAL = 3.0
"""Metres along the line."""
TIMEOUT = 0.3


class LineFollower(World):
    seconds = 30.0
    sensors = {"/line": "std_msgs/Float32"}
    buttons = {"/stop": "std_msgs/Empty", "/continue": "std_msgs/Empty"}
    commands = {"/cmd_vel": "geometry_msgs/Twist"}
    view = {"distance": 3.2, "elevation": -60.0, "azimuth": 90.0}

    def __init__(self, seed: int) -> None:
        super().__init__(seed)
        self.rover = Rover(self.model, self.data)
        self.camera = Camera(self.model, self.data)
        self.driven = 0.0
        self._near = 0
        begin = self.random.uniform(4.0, 8.0)
        self._presses = {begin: "/stop", begin + 2.0: "/continue"}
        self.observer.note(stopped=False, seen=False)

    def xml(self) -> str:
        first, second = (self.random.uniform(0.0, 2 * math.pi) for _ in range(2))
        self.line = []
        for i in range(POINTS):
            angle = 2 * math.pi * i / POINTS
            radius = 0.9 + 0.15 * math.cos(2 * angle + first) + 0.08 * math.cos(3 * angle + second)
            self.line.append((radius * math.cos(angle), radius * math.sin(angle)))
        pieces = "".join(
            f'<geom type="box" pos="{x} {y} .001" size=".035 {WIDTH} .001" rgba=".05 .05 .05 1"'
            f' euler="0 0 {math.degrees(heading)}" contype="0" conaffinity="0" group="2"/>'
            for (x, y), heading in ((self.line[i], self._direction(i)) for i in range(POINTS))
        )
        x, y = self.line[0]
        start = body(x, y, self._direction(0) + self.random.uniform(-0.3, 0.3))
        return assets(
            f"""<worldbody>{OUTSIDE}
              <geom type="plane" size="3 3 .1" rgba=".8 .8 .75 1"/>{pieces}{start}
            </worldbody><actuator>{motors()}</actuator>"""
        )

    def _direction(self, index: int) -> float:
        (x, y), (next_x, next_y) = self.line[index], self.line[(index + 1) % POINTS]
        return math.atan2(next_y - y, next_x - x)

    def sense(self) -> Iterator[Sample]:
        offset = self.offset()
        self.observer.note(seen=not math.isnan(offset))
        yield "/line", self.sensors["/line"], {"data": offset}
        for at, button in list(self._presses.items()):
            if self.time >= at:
                del self._presses[at]
                self.observer.note(stopped=button == "/stop")
                yield button, self.buttons[button], {}

    def offset(self) -> float:
        """Return where the camera sees the line: -1 right, 1 left, not a number nowhere."""
        dark = self.camera.picture()[12:].sum(axis=2) < 200
        columns = dark.sum(axis=0)
        if columns.sum() < 4:
            return math.nan
        middle = (len(columns) - 1) / 2
        return float((columns * (middle - np.arange(len(columns)))).sum() / columns.sum() / middle)

    def command(self, topic: str, message: Any) -> None:
        speed, turn = message.linear.x, message.angular.z
        if speed or turn:
            self.observer.judge("moves only while released", lambda m: not m["stopped"])
            self.observer.judge(
                "moves only with its eyes open", lambda m: m.fresh("/line", TIMEOUT)
            )
        else:
            self.observer.judge(
                "halts only for a reason",
                lambda m: m["stopped"] or not m.fresh("/line", TIMEOUT - 0.1),
            )
        self.rover.drive(speed, turn)

    def watch(self) -> None:
        x, y = self.rover.position
        steps = range(self._near - 5, self._near + 10)
        near = min(steps, key=lambda i: math.dist((x, y), self.line[i % POINTS]))
        self.driven += sum(
            math.dist(self.line[i % POINTS], self.line[(i + 1) % POINTS])
            for i in range(self._near, near)
        )
        self._near = near
        if math.dist((x, y), self.line[near % POINTS]) > 0.25:
            self.observer.violate("stays on the line")

    def succeeded(self) -> bool:
        return self.driven >= GOAL

    def place(self) -> tuple[float, float]:
        return self.rover.position

    def close(self) -> None:
        self.camera.close()
