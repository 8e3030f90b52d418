"""Worlds in which a rover drives between walls, with an emergency stop that is pressed once."""

from __future__ import annotations

import math
from collections.abc import Iterator
from typing import Any

from physics.observer import Moment
from physics.rover import Laser, Rover, body, frame, motors
from physics.world import Sample, World

__all__ = ["STOP", "TIMEOUT", "TOLD", "RoverWorld", "box", "sees", "wall"]

STOP = {"/stop": "std_msgs/Bool", "/continue": "std_msgs/Empty"}
PRESSED, RELEASED = 2.0, 1.5
"""Seconds from a press to the reset, and to the release before it."""
TOLD = 0.1
"""Seconds between two messages that say whether the button is pressed."""
TIMEOUT = 0.3
"""Seconds without a message of a sensor after which the rover must not move."""
DEAF = 0.5
"""Seconds after which a rover that hears nothing of its controller stands still by itself."""


class RoverWorld(World):
    """A world with one rover; subclasses add what is in it and what it is to do."""

    commands = {"/cmd_vel": "geometry_msgs/Twist"}
    start = (0.0, 0.0, 0.0)
    """Where the rover begins, and its heading; set it in ``things`` if the seed decides."""

    extra = ""
    """What is fixed to the rover besides."""

    def __init__(self, seed: int) -> None:
        super().__init__(seed)
        self.rover = Rover(self.model, self.data)
        self.laser = Laser(self.model, self.data, self.rover)
        self._heard = 0.0
        begin = self.random.uniform(4.0, 8.0)
        self._presses = {begin: "/stop", begin + RELEASED: "", begin + PRESSED: "/continue"}
        self._pressed, self._told = False, 0.0
        self.observer.note(stopped=False)

    def xml(self) -> str:
        things = self.things()
        return frame(f"{things}{body(*self.start, extra=self.extra)}", motors())

    def things(self) -> str:
        """Return the bodies of the world but the rover."""
        raise NotImplementedError

    def buttons_pressed(self) -> Iterator[Sample]:
        """Yield what the emergency stop says: whether it is pressed, repeated, and a reset."""
        for at, button in list(self._presses.items()):
            if self.time >= at:
                del self._presses[at]
                if button == "/continue":
                    self.observer.note(stopped=False)
                    yield button, STOP[button], {}
                    continue
                self._pressed, self._told = button == "/stop", self.time
                if self._pressed:
                    self.observer.note(stopped=True)
        if self.time >= self._told:
            self._told = self.time + TOLD
            yield "/stop", STOP["/stop"], {"data": self._pressed}

    def command(self, topic: str, message: Any) -> None:
        self._heard = self.time
        if topic == "/cmd_vel":
            speed, turn = message.linear.x, message.angular.z
            self.judge(speed, turn)
            self.rover.drive(speed, turn)

    def judge(self, speed: float, turn: float) -> None:
        """Judge a command for the wheels."""

    def control(self) -> None:
        if self.time - self._heard > DEAF:
            self.rover.drive(0.0, 0.0)

    def touches(self, prefix: str = "wall") -> bool:
        """Whether the rover touches something of that name."""
        for contact in self.data.contact:
            names = [self.model.geom(g).name for g in contact.geom]
            hull = any(n == "hull" for n in names)
            if hull and any(n.startswith(prefix) for n in names):
                return True
        return False

    def watch(self) -> None:
        if self.touches():
            self.observer.violate("touches no wall")

    def place(self) -> tuple[float, float]:
        return self.rover.position


def sees(moment: Moment, *topics: str) -> bool:
    """Whether all of the topics are fresh."""
    return all(moment.fresh(topic, TIMEOUT) for topic in topics)


def box(
    name: str, x: float, y: float, size: tuple[float, float], rgba: str, turned: float = 0.0
) -> str:
    """Return a box that stands on the floor, with half its extents."""
    return (
        f'<geom name="{name}" type="box" pos="{x} {y} .15" size="{size[0]} {size[1]} .15"'
        f' euler="0 0 {math.degrees(turned)}" rgba="{rgba}"/>'
    )


def wall(name: str, begin: tuple[float, float], end: tuple[float, float]) -> str:
    """Return a wall between two places."""
    (x, y), (u, v) = begin, end
    middle = ((x + u) / 2, (y + v) / 2)
    length = math.hypot(u - x, v - y) / 2 + 0.03
    turned = math.atan2(v - y, u - x)
    return box(f"wall{name}", *middle, (length, 0.03), ".6 .55 .5 1", turned)
