"""A floor with a line, a robot with differential drive on it, and obstacles. No ROS.

Units and frames follow REP 103 and 105: metres, seconds, radians; x forward, y left.
"""

from __future__ import annotations

import bisect
import math
from dataclasses import dataclass

__all__ = ["OBSTACLES", "SENSOR_HALF_WIDTH", "Pose", "Robot", "Track", "World", "standard_track"]

SENSOR_HALF_WIDTH = 0.25
"""The line sensor sees this far to either side."""
SENSOR_AHEAD = 0.3
"""How far in front of the axle the line sensor sits."""
BUMPER = 0.15
"""From the axle to the front of the robot, where the distance sensor sits."""
FAR = 3.0
"""What the distance sensor reports if there is nothing in front of it."""
BEAM = math.radians(40.0)
"""Half the opening angle of the distance sensor."""
OBSTACLE_RADIUS = 0.05
ACCELERATION = 1.0
"""The drive changes the speed by at most this much per second."""
COMMAND_TIMEOUT = 2.0
"""The drive halts when it has heard nothing for this long, in simulated seconds."""

OBSTACLES = (2.2, 6.3, 9.6)
"""Arc lengths of the line at which something gets in the way."""


@dataclass(frozen=True)
class Pose:
    x: float
    y: float
    heading: float


class Track:
    """A closed line through points (Catmull-Rom spline) with gaps (intervals of arc length)."""

    def __init__(
        self,
        points: list[tuple[float, float]],
        gaps: tuple[tuple[float, float], ...] = (),
        step: float = 0.01,
    ) -> None:
        self.gaps = gaps
        self.points: list[tuple[float, float]] = []
        count = len(points)
        for i in range(count):
            corners = [points[(i + k - 1) % count] for k in range(4)]
            pieces = max(1, int(math.dist(corners[1], corners[2]) / step))
            self.points.extend(_spline(corners, k / pieces) for k in range(pieces))
        self.lengths = [0.0]
        for a, b in zip(self.points, self.points[1:] + self.points[:1], strict=True):
            self.lengths.append(self.lengths[-1] + math.dist(a, b))
        self.length = self.lengths[-1]

    def at(self, arc: float) -> Pose:
        """The place at an arc length, and the line's direction there."""
        index = bisect.bisect_right(self.lengths, arc % self.length) - 1
        a, b = self.points[index], self.points[(index + 1) % len(self.points)]
        return Pose(a[0], a[1], math.atan2(b[1] - a[1], b[0] - a[0]))

    def nearest(self, x: float, y: float, around: float, window: float = 0.6) -> float:
        """Arc length of the nearest place of the line within a window around an arc length."""
        spacing = self.length / len(self.points)
        middle = int(around % self.length / spacing)
        reach = int(window / spacing)
        candidates = ((middle + k) % len(self.points) for k in range(-reach, reach + 1))
        return self.lengths[min(candidates, key=lambda i: math.dist(self.points[i], (x, y)))]

    def in_gap(self, arc: float) -> bool:
        return any(start <= arc % self.length <= end for start, end in self.gaps)


def _spline(corners: list[tuple[float, float]], t: float) -> tuple[float, float]:
    def blend(a: float, b: float, c: float, d: float) -> float:
        return 0.5 * (
            2 * b + (c - a) * t + (2 * a - 5 * b + 4 * c - d) * t**2 + (3 * (b - c) + d - a) * t**3
        )

    x, y = (blend(*axis) for axis in zip(*corners, strict=True))
    return x, y


def standard_track() -> Track:
    """About eleven metres, curves both ways, and one gap of half a metre."""
    points = [
        (0, 0),
        (1.5, 0),
        (3, 0.2),
        (3.7, 1.2),
        (3, 2.1),
        (2, 1.8),
        (1, 2.2),
        (-0.4, 2),
        (-0.9, 0.9),
    ]
    return Track([(float(x), float(y)) for x, y in points], gaps=((0.6, 1.1),))


class Robot:
    """Differential drive: takes a speed and a rate of turn, and moves on the floor."""

    def __init__(self, pose: Pose) -> None:
        self.pose = pose
        self.speed = 0.0
        self.turn = 0.0
        self._wanted = (0.0, 0.0)
        self._age = 0.0

    def command(self, speed: float, turn: float) -> None:
        self._wanted = (speed, turn)
        self._age = 0.0

    def step(self, seconds: float) -> None:
        self._age += seconds
        speed, turn = self._wanted if self._age <= COMMAND_TIMEOUT else (0.0, 0.0)
        change = ACCELERATION * seconds
        self.speed += max(-change, min(change, speed - self.speed))
        self.turn = turn if self.speed else 0.0
        heading = self.pose.heading + self.turn * seconds / 2
        self.pose = Pose(
            self.pose.x + self.speed * math.cos(heading) * seconds,
            self.pose.y + self.speed * math.sin(heading) * seconds,
            self.pose.heading + self.turn * seconds,
        )


class World:
    """The track, the robot and the obstacle that is in the way at the moment, if any.

    An obstacle appears when the robot comes within ``appear`` metres of its place, and is gone when
    it was grabbed; in the next lap it is there again.
    """

    def __init__(
        self, track: Track, obstacles: tuple[float, ...] = OBSTACLES, appear: float = 0.8
    ) -> None:
        self.track = track
        self.robot = Robot(track.at(0.0))
        self._places = obstacles
        self._appear = appear
        self._arc = 0.0
        self._next = 0
        self.obstacle: Pose | None = None
        self.touched = False
        """Whether the robot has run into the obstacle that is there."""

    def step(self, seconds: float) -> None:
        self.robot.step(seconds)
        x, y = self._sensor()
        self._arc = self.track.nearest(x, y, self._arc)
        place = self._places[self._next] if self._places else math.inf
        if self.obstacle is None and 0.0 < place - self._arc < self._appear:
            self.obstacle = self.track.at(place)
        if self.obstacle is not None:
            gap = math.hypot(
                self.obstacle.x - self.robot.pose.x, self.obstacle.y - self.robot.pose.y
            )
            self.touched = self.touched or gap < BUMPER + OBSTACLE_RADIUS

    def distance(self) -> float:
        """From the front of the robot to what stands before it."""
        if self.obstacle is None:
            return FAR
        pose = self.robot.pose
        dx, dy = self.obstacle.x - pose.x, self.obstacle.y - pose.y
        bearing = math.atan2(dy, dx) - pose.heading
        if math.cos(bearing) < math.cos(BEAM):
            return FAR
        return min(FAR, max(0.0, math.hypot(dx, dy) - BUMPER - OBSTACLE_RADIUS))

    def correction(self) -> float | None:
        """Where the line lies, in percent of the sensor's half width, left positive, if at all."""
        if self.track.in_gap(self._arc):
            return None
        x, y = self._sensor()
        line = self.track.at(self._arc)
        offset = (line.y - y) * math.cos(line.heading) - (line.x - x) * math.sin(line.heading)
        if abs(offset) > SENSOR_HALF_WIDTH:
            return None
        return 100.0 * offset / SENSOR_HALF_WIDTH

    def grab(self) -> bool:
        """Take the obstacle away; False if there is none within reach."""
        if self.obstacle is None or self.distance() > 0.5:
            return False
        self.obstacle = None
        self.touched = False
        self._next = (self._next + 1) % len(self._places)
        return True

    def _sensor(self) -> tuple[float, float]:
        pose = self.robot.pose
        return (
            pose.x + SENSOR_AHEAD * math.cos(pose.heading),
            pose.y + SENSOR_AHEAD * math.sin(pose.heading),
        )
