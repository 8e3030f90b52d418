"""The room with columns; a user clicks twice, and wants to see all around from there."""

from __future__ import annotations

import math
from typing import Any

from physics.rover_world import STOP
from physics.tasks import Turn
from physics.world import Task
from physics.worlds.go_to_pose import GOAL, GoToPose

__all__ = ["Inspection"]

VIEWS = 4


class Inspection(GoToPose):
    seconds = 60.0
    buttons = {**STOP, "/clicked_point": "geometry_msgs/PointStamped"}
    commands = {"/alive": "std_msgs/Empty", "/photo": "std_msgs/Empty"}
    actions = {"/drive": "gallery_msgs/Drive", "/turn": "gallery_msgs/Turn"}

    def __init__(self, seed: int) -> None:
        super().__init__(seed)
        self._headings: list[float] = []
        self.observer.note(stands=True, there=False)

    def command(self, topic: str, message: Any) -> None:
        super().command(topic, message)
        if topic == "/photo":
            self.observer.judge("photographs only while it stands", lambda m: m["stands"])
            self.observer.judge("photographs only at the place", lambda m: m["there"])
            if self.rover.distance(*GOAL) < 0.15:
                self._headings.append(self.rover.heading)

    def begin(self, action: str, request: Any) -> Task:
        if action == "/turn":
            self.observer.judge("turns only at the place", lambda m: m["there"])
            return Turn(self.rover, request.angle)
        return super().begin(action, request)

    def watch(self) -> None:
        super().watch()
        goal = self.goal
        there = goal is not None and self.rover.distance(*goal) < 0.15
        stands = math.hypot(self.rover.speed, self.rover.turn) < 0.01
        self.observer.note(there=there, stands=stands)

    def succeeded(self) -> bool:
        return len(self._headings) >= VIEWS
