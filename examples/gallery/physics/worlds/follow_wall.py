"""A room with a winding wall, and a red sign that the camera sees from near by."""

from __future__ import annotations

import math
from collections.abc import Iterator

from physics.rover import Camera, Laser
from physics.rover_world import RoverWorld, box, sees, wall
from physics.world import STEP, Sample

__all__ = ["FollowWall"]

SIGN = 60
"""So many red pixels are the sign."""


class FollowWall(RoverWorld):
    seconds = 60.0
    sensors = {"/scan": Laser.TYPE, "/sign": "std_msgs/Bool"}
    view = {"distance": 5.2, "elevation": -60.0, "azimuth": 90.0}

    def __init__(self, seed: int) -> None:
        super().__init__(seed)
        self._camera = Camera(self.model, self.data)
        self._arrived = 0.0
        self._seen = False
        self.observer.note(sign=False)

    def things(self) -> str:
        step, depth = self.random.uniform(-0.3, 0.3), self.random.uniform(0.4, 0.7)
        # Counterclockwise, with the wall on the right, from the lower left corner.
        corners = [
            (-1.8, -1.5), (step, -1.5), (step, -1.5 + depth), (1.8, -1.5 + depth), (1.8, 1.5),
            (-step, 1.5), (-step, 1.5 - depth), (-1.8, 1.5 - depth),
        ]  # fmt: skip
        self.start = (-1.3, -1.1, self.random.uniform(-0.3, 0.3))
        self._sign = (-1.2, 1.5 - depth - 0.05)
        pairs = zip(corners, [*corners[1:], corners[0]], strict=True)
        walls = "".join(wall(str(i), *ends) for i, ends in enumerate(pairs))
        sign = box("sign", -1.74, self.random.uniform(-0.4, 0.2), (0.02, 0.2), ".9 .1 .1 1")
        return walls + sign

    def sense(self) -> Iterator[Sample]:
        yield "/scan", Laser.TYPE, self.laser.scan()
        if round(self.time / 0.05) % 2 == 0:
            picture = self._camera.picture().astype(int)
            red = (picture[..., 0] > 100) & (picture[..., 1:].max(axis=2) * 2 < picture[..., 0])
            seen = int(red.sum()) > SIGN
            self._seen |= seen
            self.observer.note(sign=seen)
            yield "/sign", self.sensors["/sign"], {"data": seen}

    def judge(self, speed: float, turn: float) -> None:
        if speed or turn:
            self.observer.judge("moves only if it sees", lambda m: sees(m, *self.sensors))
            self.observer.judge("moves only before the sign", lambda m: not m["sign"])

    def watch(self) -> None:
        super().watch()
        stands = math.hypot(self.rover.speed, self.rover.turn) == 0.0
        at_sign = stands and self._seen and self._is_at_sign()
        self._arrived = self._arrived + STEP if at_sign else 0.0

    def _is_at_sign(self) -> bool:
        x, y, _ = self.data.geom("sign").xpos
        return self.rover.distance(x, y) < 1.5

    def succeeded(self) -> bool:
        """Whether it has been standing before the sign for a second."""
        return self._arrived > 1.0

    def close(self) -> None:
        self._camera.close()
