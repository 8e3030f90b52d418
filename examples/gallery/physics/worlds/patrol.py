"""The room with columns, two places to be watched, a battery, and a dock in the corner."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

from physics.rover import Laser
from physics.rover_world import STOP
from physics.tasks import Drive, Place, way
from physics.world import STEP, Sample, Task
from physics.worlds.go_to_pose import GoToPose

__all__ = ["Patrol"]

DOCK = (-1.4, -1.4)
BEFORE_DOCK = (-1.0, -1.0)
WATCHED = ((1.3, 1.3), (1.3, -1.3))
LOW = 0.3
SECONDS = 45.0
"""For which a full battery lasts."""
CHARGING = 4.0
"""For which an empty one is charged."""
SILENCE = 1.0
"""Seconds without a word of the battery after which the robot must return."""


class Patrol(GoToPose):
    seconds = 120.0
    sensors = {"/scan": Laser.TYPE, "/battery": "sensor_msgs/BatteryState"}
    buttons = STOP
    actions = {"/drive": "gallery_msgs/Drive", "/dock": "gallery_msgs/Drive"}
    free = (*WATCHED, DOCK, BEFORE_DOCK)

    def __init__(self, seed: int) -> None:
        super().__init__(seed)
        self._charge = 1.0
        self._watched: set[Place] = set()
        self._was_low = False
        self.observer.note(charge=1.0, before_dock=True)

    def sense(self) -> Iterator[Sample]:
        yield "/scan", Laser.TYPE, self.laser.scan()
        yield "/battery", self.sensors["/battery"], {"percentage": self._charge}
        yield from self.buttons_pressed()

    def begin(self, action: str, request: Any) -> Task:
        goal = (request.x, request.y)
        if action == "/dock":
            self.observer.judge("docks only from before the dock", lambda m: m["before_dock"])
            return Drive(self.rover, [DOCK])
        if goal in WATCHED:
            self.observer.judge("patrols only while charged", lambda m: m["charge"] >= LOW)
            self.observer.judge(
                "patrols only while the battery is heard", lambda m: m.fresh("/battery", SILENCE)
            )
        else:
            self.observer.judge("returns to its dock", lambda _: goal == BEFORE_DOCK)
        return Drive(self.rover, way(self.rover.position, goal, self.is_free))

    def watch(self) -> None:
        super().watch()
        is_docked = self.rover.distance(*DOCK) < 0.15
        change = STEP / CHARGING if is_docked else -STEP / SECONDS
        self._charge = min(1.0, max(0.0, self._charge + change))
        self._was_low |= self._charge < LOW
        self._watched |= {place for place in WATCHED if self.rover.distance(*place) < 0.15}
        before_dock = self.rover.distance(*BEFORE_DOCK) < 0.6
        self.observer.note(charge=self._charge, before_dock=before_dock)

    def succeeded(self) -> bool:
        """It has seen both places, and come home for want of charge."""
        at_home = self.rover.distance(*DOCK) < 0.15
        return len(self._watched) == len(WATCHED) and self._was_low and at_home
