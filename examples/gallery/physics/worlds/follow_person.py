"""A person walks through an open hall; the laser's tracker reports where the person is, until the
rover's battery is empty."""

from __future__ import annotations

import math
from collections.abc import Iterator

from physics.rover_world import STOP, RoverWorld, sees
from physics.world import Sample

__all__ = ["FollowPerson"]

NEAR, FAR = 0.7, 2.5
"""Metres: nearer the rover must not move towards the person, farther it has lost the person."""
SECONDS = 18.0
KEPT = 0.95
EMPTY = 0.2
"""The charge at which the rover must stand."""
PERSON = """<body name="person" mocap="true" pos="{x} {y} 0">
  <geom name="wall_person" type="cylinder" pos="0 0 .5" size=".15 .5" rgba=".3 .6 .3 1"/>
</body>"""


class FollowPerson(RoverWorld):
    seconds = 30.0
    sensors = {"/person": "geometry_msgs/PointStamped", "/battery": "sensor_msgs/BatteryState"}
    buttons = STOP
    view = {"distance": 6.0, "elevation": -55.0, "azimuth": 90.0}

    def __init__(self, seed: int) -> None:
        super().__init__(seed)
        self._phase = self.random.uniform(0.0, 2 * math.pi)
        self._pause = self.random.uniform(6.0, 12.0)
        self._walked = 0.0
        self._kept = self._lost = 0
        self._empty = self.random.uniform(14.0, 16.0)
        self.observer.note(distance=math.inf, charge=1.0)

    def things(self) -> str:
        self.start = (-1.0, 0.0, self.random.uniform(-0.5, 0.5))
        return PERSON.format(x=0.2, y=0.0)

    def control(self) -> None:
        """The person walks along a figure of eight, and waits for three seconds once."""
        super().control()
        if not self._pause < self.time < self._pause + 3.0:
            self._walked += 0.05
        angle = 0.25 * self._walked
        x = 0.2 + 1.5 * math.sin(angle)
        y = 1.1 * math.sin(2 * angle) * math.copysign(1.0, math.cos(self._phase))
        self.data.mocap_pos[0][:2] = (x, y)

    @property
    def _person(self) -> tuple[float, float]:
        x, y, _ = self.data.mocap_pos[0]
        return float(x), float(y)

    def sense(self) -> Iterator[Sample]:
        distance, bearing = self.rover.distance(*self._person), self.rover.bearing(*self._person)
        self.observer.note(distance=distance)
        point = {"x": distance * math.cos(bearing), "y": distance * math.sin(bearing)}
        yield "/person", self.sensors["/person"], {"header": {"frame_id": "base"}, "point": point}
        charge = 1.0 - (1.0 - EMPTY) * self.time / self._empty
        self.observer.note(charge=charge)
        battery = {"voltage": 11.0 + charge, "percentage": charge, "present": True}
        yield "/battery", self.sensors["/battery"], {"header": {"frame_id": "base"}, **battery}
        yield from self.buttons_pressed()

    def judge(self, speed: float, turn: float) -> None:
        if speed or turn:
            self.observer.judge("moves only while released", lambda m: not m["stopped"])
            self.observer.judge("moves only if it sees", lambda m: sees(m, *self.sensors))
            self.observer.judge("moves only while charged", lambda m: m["charge"] > EMPTY)
        if speed > 0.0:
            self.observer.judge("keeps its distance", lambda m: m["distance"] > NEAR)

    def watch(self) -> None:
        super().watch()
        if self.time > self._empty:
            return
        if self.rover.distance(*self._person) < FAR:
            self._kept += 1
        else:
            self._lost += 1

    def succeeded(self) -> bool:
        """Whether it kept near the person as long as it could, and stands then."""
        stands = math.hypot(self.rover.speed, self.rover.turn) == 0.0
        near = self._kept / (self._kept + self._lost) if self.time >= SECONDS else 0.0
        return stands and near >= KEPT
