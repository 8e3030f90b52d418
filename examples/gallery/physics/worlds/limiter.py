"""A room with columns, in which somebody steers who looks at nothing."""

from __future__ import annotations

import math
from collections.abc import Iterator

from physics.rover import Laser
from physics.rover_world import TIMEOUT, RoverWorld, box, sees, wall
from physics.teleoperation import CURVES
from physics.world import Sample

__all__ = ["Limiter"]

FASTEST, NEAR, NEAREST = 0.5, 0.25, 0.15
AHEAD = 60
"""Degrees to each side."""
WAY = 1.0
"""Metres."""
DRIVEN = 15.0
"""Seconds."""


class Limiter(RoverWorld):
    seconds = 20.0
    sensors = {"/scan": Laser.TYPE}
    commands = {"/cmd_vel": "geometry_msgs/Twist", "/alive": "std_msgs/Empty"}
    view = {"distance": 5.0, "elevation": -60.0, "azimuth": 90.0}

    def __init__(self, seed: int) -> None:
        super().__init__(seed)
        self._way = 0.0
        self._at = self.rover.position
        self.observer.note(ahead=0.0, beside=0.0)

    def things(self) -> str:
        corners = [(-2.0, -1.9), (2.0, -1.9), (2.0, 1.9), (-2.0, 1.9)]
        walls = "".join(
            wall(str(i), *ends)
            for i, ends in enumerate(zip(corners, [*corners[1:], corners[0]], strict=True))
        )
        self.start = (0.0, 0.0, self.random.uniform(-math.pi, math.pi))
        columns = []
        for number, angle in enumerate((0.7, 2.4, 3.9, 5.5)):
            turned = angle + self.random.uniform(-0.3, 0.3)
            x, y = math.cos(turned), math.sin(turned)
            columns.append(box(f"wallcolumn{number}", x, y, (0.08, 0.08), ".5 .6 .5 1", turned))
        return walls + "".join(columns)

    def sense(self) -> Iterator[Sample]:
        scan = self.laser.scan()
        ranges = scan["ranges"]
        self.observer.note(ahead=min(*ranges[-AHEAD:], *ranges[: AHEAD + 1]), beside=min(ranges))
        yield "/scan", Laser.TYPE, scan

    def judge(self, speed: float, turn: float) -> None:
        if speed or turn:
            self.observer.judge("moves only if it sees", lambda m: sees(m, "/scan"))
        if speed:
            # What it has seen last may be so old, and it has come nearer since.
            nearer = speed * TIMEOUT + 1e-6
            self.observer.judge(
                "is slow enough",
                lambda m: (
                    0.0 < speed <= min(FASTEST, m["ahead"] - NEAREST, m["beside"]) + nearer
                    and m["ahead"] >= NEAR - nearer
                ),
            )
            self.observer.judge("is never too fast", lambda m: speed <= FASTEST)
            keeps = any(abs(turn - curve * speed) < 1e-6 for curve in CURVES)
            self.observer.judge("keeps the curve", lambda m: keeps)

    def watch(self) -> None:
        super().watch()
        before, self._at = self._at, self.rover.position
        self._way += math.dist(before, self._at)

    def succeeded(self) -> bool:
        """Whether it has driven some way for some time."""
        return self.time > DRIVEN and self._way > WAY
