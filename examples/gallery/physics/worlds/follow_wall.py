"""A room with a winding wall, a black sign that the camera sees from near by, and somebody who
kicks the bumper."""

from __future__ import annotations

import math
from collections.abc import Iterator

from physics.rover import Camera, Laser
from physics.rover_world import TOLD, RoverWorld, box, sees, wall
from physics.world import STEP, Sample

__all__ = ["FollowWall"]

SIGN = 60
"""So many black pixels are the sign."""
BLACK = 30
PRESSED = 1.5
"""Seconds."""
CENTER = 1


class FollowWall(RoverWorld):
    seconds = 60.0
    sensors = {"/scan": Laser.TYPE, "/camera/image": "sensor_msgs/Image"}
    buttons = {"/bumper": "kobuki_msgs/BumperEvent"}
    view = {"distance": 5.2, "elevation": -60.0, "azimuth": 90.0}

    def __init__(self, seed: int) -> None:
        super().__init__(seed)
        self._camera = Camera(self.model, self.data)
        self._arrived = 0.0
        self._seen = False
        begin = self.random.uniform(7.0, 10.0)
        self._bumped, self._told = False, 0.0
        self._bumps = {begin: True, begin + PRESSED: False}
        self.observer.note(sign=False, bumped=False)

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
        sign = box("sign", -1.74, self.random.uniform(-0.4, 0.2), (0.02, 0.2), ".02 .02 .02 1")
        return walls + sign

    def sense(self) -> Iterator[Sample]:
        yield "/scan", Laser.TYPE, self.laser.scan()
        if round(self.time / 0.05) % 2 == 0:
            picture = self._camera.picture().mean(axis=2).astype("uint8")
            seen = int((picture < BLACK).sum()) > SIGN
            self._seen |= seen
            self.observer.note(sign=seen)
            height, width = picture.shape
            size = {"height": height, "width": width, "step": width, "encoding": "mono8"}
            yield (
                "/camera/image",
                self.sensors["/camera/image"],
                {"header": {"frame_id": "camera"}, **size, "data": picture.tobytes()},
            )
        for at, is_pressed in list(self._bumps.items()):
            if self.time >= at:
                del self._bumps[at]
                self._bumped, self._told = is_pressed, self.time
                self.observer.note(bumped=is_pressed)
        if self.time >= self._told:
            self._told = self.time + TOLD
            fields = {"bumper": CENTER, "state": int(self._bumped)}
            yield "/bumper", self.buttons["/bumper"], fields

    def judge(self, speed: float, turn: float) -> None:
        if speed or turn:
            self.observer.judge("moves only if it sees", lambda m: sees(m, *self.sensors))
            self.observer.judge("moves only before the sign", lambda m: not m["sign"])
            self.observer.judge("moves only while nobody kicks it", lambda m: not m["bumped"])

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
