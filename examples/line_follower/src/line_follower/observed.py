"""What an observer of the robot has seen and counted. No ROS, and nothing of robosc."""

from __future__ import annotations

import json
import math
from pathlib import Path
from typing import Any

from line_follower.judge import Judge

__all__ = ["Observed"]


class Observed:
    """Tell it what the topics say, and when (any steady clock); it judges, counts and sums up."""

    def __init__(self, tolerance: float) -> None:
        self.judge = Judge(tolerance)
        self.path: list[tuple[float, float]] = []
        self.metres = 0.0
        self.counts = dict.fromkeys(["stops", "grabs", "missed_grabs", "light_switches"], 0)
        self._moving = False
        self._places: list[tuple[float, float]] = []
        self._active: set[Any] = set()

    def velocity(self, now: float, speed: float, turn: float) -> None:
        moving = speed != 0.0 or turn != 0.0
        self.counts["stops"] += self._moving and not moving
        self._moving = moving
        self.judge.velocity(now, speed, turn)

    def goal(self, now: float, identifier: Any) -> None:
        self._active.add(identifier)
        if self.path:
            self._places.append(self.path[-1])
        self.judge.grab(now)

    def result(self, now: float, identifier: Any, succeeded: bool) -> None:
        self._active.discard(identifier)
        self.counts["grabs" if succeeded else "missed_grabs"] += 1
        if not self._active:
            self.judge.grab_ended(now)

    def light(self, now: float, on: bool) -> None:
        self.counts["light_switches"] += 1
        self.judge.light(now, on)

    def pose(self, x: float, y: float) -> None:
        if self.path:
            self.metres += math.dist(self.path[-1], (x, y))
        self.path.append((x, y))

    def write(self, file: str) -> str:
        """Return the summary; write it, with the path of the robot, if a file is given."""
        self.judge.settle(math.inf)
        summary = {
            "metres": round(self.metres, 2),
            **self.counts,
            "commands_judged": self.judge.commands,
            "tolerance": self.judge.tolerance,
            "late": round(self.judge.latest, 3),
            "violations": self.judge.violations,
        }
        whole = {
            **summary,
            "path": [[round(x, 4), round(y, 4)] for x, y in self.path],
            "grab_places": self._places,
        }
        if file:
            Path(file).write_text(json.dumps(whole), encoding="utf-8")
        return json.dumps(summary)
