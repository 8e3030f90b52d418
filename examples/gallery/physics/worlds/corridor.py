"""Two rooms, a corridor between them that takes one rover, and two rovers."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

from physics.rover import ODOMETRY, RADIUS, Rover, body, frame, motors, odometry
from physics.rover_world import sees, wall
from physics.tasks import Drive, Place, way
from physics.world import Sample, Task, World

__all__ = ["Corridor"]

LONG, HALF = 1.6, 0.95
"""Half the length and width of everything, in metres."""
INSIDE, NARROW = 0.6, 0.28
"""Half the length and width of the corridor."""
CROSSINGS = 2
"""So often each rover is to cross it."""
NAMES = ("robot_1", "robot_2")
COLOURS = (".2 .4 .8 1", ".8 .4 .2 1")
CORNERS = [
    (-LONG, -HALF), (-INSIDE, -HALF), (-INSIDE, -NARROW), (INSIDE, -NARROW), (INSIDE, -HALF),
    (LONG, -HALF), (LONG, HALF), (INSIDE, HALF), (INSIDE, NARROW), (-INSIDE, NARROW),
    (-INSIDE, HALF), (-LONG, HALF),
]  # fmt: skip


class Corridor(World):
    seconds = 60.0
    sensors = {f"/{name}/odom": ODOMETRY for name in NAMES}
    commands = {"/alive": "std_msgs/Empty"}
    actions = {f"/{name}/drive": "gallery_msgs/Drive" for name in NAMES}
    view = {"distance": 4.2, "elevation": -65.0, "azimuth": 90.0}

    def __init__(self, seed: int) -> None:
        super().__init__(seed)
        self.rovers = {name: Rover(self.model, self.data, name) for name in NAMES}
        self._sides = dict.fromkeys(NAMES, 0.0)
        self._crossings = dict.fromkeys(NAMES, -1)

    def xml(self) -> str:
        ends = [*CORNERS[1:], CORNERS[0]]
        walls = "".join(
            wall(str(i), *both) for i, both in enumerate(zip(CORNERS, ends, strict=True))
        )
        starts = ((-1.1, 0.5), (1.1, -0.5))
        rovers = "".join(
            body(*start, self.random.uniform(-3.0, 3.0), name, colour)
            for start, name, colour in zip(starts, NAMES, COLOURS, strict=True)
        )
        return frame(walls + rovers, "".join(map(motors, NAMES)))

    def sense(self) -> Iterator[Sample]:
        for name, rover in self.rovers.items():
            yield f"/{name}/odom", ODOMETRY, odometry(rover)

    def command(self, topic: str, message: Any) -> None:
        """Take a sign of life, which is all that is sent but goals."""

    def begin(self, action: str, request: Any) -> Task:
        rover = self.rovers[action.split("/")[1]]
        return Drive(rover, way(rover.position, (request.x, request.y), is_free))

    def watch(self) -> None:
        inside = 0
        for name, rover in self.rovers.items():
            if f"/{name}/drive" in self.busy:
                topic = f"/{name}/odom"
                self.observer.judge("drives only if it sees", lambda m, t=topic: sees(m, t))
            x, _ = rover.position
            inside += abs(x) < INSIDE
            if abs(x) > INSIDE + RADIUS and x * self._sides[name] <= 0.0:
                self._sides[name] = x
                self._crossings[name] += 1
        if inside > 1:
            self.observer.violate("one in the corridor")
        for contact in self.data.contact:
            names = [self.model.geom(g).name for g in contact.geom]
            if any(n.endswith("hull") for n in names) and "floor" not in names:
                self.observer.violate("touches nothing")

    def succeeded(self) -> bool:
        return min(self._crossings.values()) >= CROSSINGS

    def place(self) -> Place:
        return self.rovers["robot_1"].position


def is_free(at: Place) -> bool:
    """Whether a rover that stands there is away from all walls."""
    x, y = abs(at[0]), abs(at[1])
    margin = RADIUS + 0.06
    in_room = INSIDE + margin < x < LONG - margin and y < HALF - margin
    return in_room or (x <= INSIDE + margin and y < NARROW - margin)
