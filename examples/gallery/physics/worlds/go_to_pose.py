"""A room with columns, an action that drives to a place, and a user who clicks twice."""

from __future__ import annotations

import math
from collections.abc import Iterator
from typing import Any, ClassVar

from physics.rover import RADIUS, Laser
from physics.rover_world import STOP, RoverWorld, sees, wall
from physics.tasks import Drive, Place, way
from physics.world import Sample, Task

__all__ = ["GOAL", "GoToPose"]

HALF = 1.8
COLUMN = 0.18
MARGIN = RADIUS + 0.1
GOAL = (1.3, 1.3)
CORNERS = [(-HALF, -HALF), (HALF, -HALF), (HALF, HALF), (-HALF, HALF)]


class GoToPose(RoverWorld):
    seconds = 40.0
    sensors = {"/scan": Laser.TYPE}
    buttons = {**STOP, "/clicked_point": "geometry_msgs/PointStamped"}
    commands = {"/alive": "std_msgs/Empty"}
    actions = {"/drive": "gallery_msgs/Drive"}
    free: ClassVar[tuple[Place, ...]] = (GOAL,)
    """Where no column stands."""
    view = {"distance": 5.2, "elevation": -60.0, "azimuth": 90.0}

    def __init__(self, seed: int) -> None:
        super().__init__(seed)
        self._driving: Drive | None = None
        self.goal: Place | None = None
        self._clicks = {0.5: (1.4, self.random.uniform(-1.4, 0.0)), 3.0: GOAL}
        self.observer.note(goal=None)

    def things(self) -> str:
        self.start = (-1.4, -1.4, self.random.uniform(0.0, 1.5))
        self._columns: list[Place] = []
        tries = 0
        while len(self._columns) < 5:
            tries += 1
            if tries % 1000 == 0:  # there is no room for another beside those
                self._columns.clear()
            at = self.random.uniform(-1.1, 1.1), self.random.uniform(-1.1, 1.1)
            apart = all(math.dist(at, c) > 0.9 for c in self._columns)
            if apart and all(math.dist(at, place) > COLUMN + MARGIN for place in self.free):
                self._columns.append(at)
        columns = "".join(
            f'<geom name="wall_column{i}" type="cylinder" pos="{x} {y} .2" size="{COLUMN} .2"'
            ' rgba=".8 .5 .3 1"/>'
            for i, (x, y) in enumerate(self._columns)
        )
        ends = [*CORNERS[1:], CORNERS[0]]
        return columns + "".join(
            wall(str(i), begin, end)
            for i, (begin, end) in enumerate(zip(CORNERS, ends, strict=True))
        )

    def is_free(self, at: Place) -> bool:
        inside = max(abs(at[0]), abs(at[1])) < HALF - MARGIN
        return inside and all(math.dist(at, c) > COLUMN + MARGIN for c in self._columns)

    def sense(self) -> Iterator[Sample]:
        yield "/scan", Laser.TYPE, self.laser.scan()
        yield from self.buttons_pressed()
        for at, (x, y) in list(self._clicks.items()):
            if self.time >= at:
                del self._clicks[at]
                self.goal = (x, y)
                self.observer.note(goal=self.goal)
                fields = {"header": {"frame_id": "map"}, "point": {"x": x, "y": y}}
                yield "/clicked_point", self.buttons["/clicked_point"], fields

    def begin(self, action: str, request: Any) -> Task:
        goal = (request.x, request.y)
        self.observer.judge("drives to the last click", lambda m: m["goal"] == goal)
        self._driving = Drive(self.rover, way(self.rover.position, goal, self.is_free))
        return self._driving

    def watch(self) -> None:
        super().watch()
        if math.hypot(self.rover.speed, self.rover.turn) > 0.0:
            self.observer.judge("drives only while released", lambda m: not m["stopped"])
            self.observer.judge("drives only if it sees", lambda m: sees(m, "/scan"))

    def succeeded(self) -> bool:
        return not self._clicks and self.rover.distance(*GOAL) < 0.15
