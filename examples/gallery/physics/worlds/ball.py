"""A ball that lies somewhere before a goal; a detector reports where the camera sees the two."""

from __future__ import annotations

import math
from collections.abc import Iterator

from physics.rover_world import STOP, RoverWorld, sees
from physics.world import Sample

__all__ = ["Ball"]

GOAL = (1.8, 0.0)
WIDTH = 0.45
"""Half the goal's width."""
VIEW = math.radians(70.0)
"""How far to each side the detector sees."""
POINT = "geometry_msgs/PointStamped"
THINGS = """
<body name="ball" pos="{x} {y} .06"><freejoint/>
  <geom name="ball" type="sphere" size=".06" mass=".05" rgba=".95 .5 .1 1" condim="6"
        friction=".8 .005 .004" solref=".02 1.2"/></body>
<geom name="wall_back" type="box" pos="2.2 0 .1" size=".03 .5 .1" rgba=".3 .3 .9 1"/>
<geom name="wall_left" type="box" pos="2.0 .5 .1" size=".2 .03 .1" rgba=".3 .3 .9 1"/>
<geom name="wall_right" type="box" pos="2.0 -.5 .1" size=".2 .03 .1" rgba=".3 .3 .9 1"/>"""
SCOOP = """
<geom name="scoop_left" type="box" pos=".115 .062 .0" euler="0 0 -30" size=".035 .006 .025"
      mass=".03" rgba=".2 .2 .2 1" group="1"/>
<geom name="scoop_right" type="box" pos=".115 -.062 .0" euler="0 0 30" size=".035 .006 .025"
      mass=".03" rgba=".2 .2 .2 1" group="1"/>"""


class Ball(RoverWorld):
    seconds = 60.0
    sensors = {"/ball": POINT, "/goal": POINT}
    buttons = STOP
    extra = SCOOP
    view = {"distance": 5.0, "elevation": -55.0, "azimuth": 90.0}

    def __init__(self, seed: int) -> None:
        super().__init__(seed)
        self.observer.note(**dict.fromkeys(self.sensors, False))

    def things(self) -> str:
        self.start = (-1.2, self.random.uniform(-0.5, 0.5), self.random.uniform(-3.0, 3.0))
        return THINGS.format(x=self.random.uniform(-0.4, 0.1), y=self.random.uniform(-0.5, 0.5))

    @property
    def _ball(self) -> tuple[float, float]:
        x, y, _ = self.data.body("ball").xpos
        return float(x), float(y)

    def sense(self) -> Iterator[Sample]:
        for topic, at in (("/ball", self._ball), ("/goal", GOAL)):
            distance, bearing = self.rover.distance(*at), self.rover.bearing(*at)
            seen = abs(bearing) < VIEW
            self.observer.note(**{topic: seen})
            x = distance * math.cos(bearing) if seen else math.nan
            y = distance * math.sin(bearing) if seen else math.nan
            yield topic, POINT, {"header": {"frame_id": "base"}, "point": {"x": x, "y": y}}
        yield from self.buttons_pressed()

    def judge(self, speed: float, turn: float) -> None:
        if speed or turn:
            self.observer.judge("moves only while released", lambda m: not m["stopped"])
            self.observer.judge("moves only if it sees", lambda m: sees(m, *self.sensors))
        if speed > 0.0:
            self.observer.judge("drives only to a ball it sees", lambda m: m["/ball"])

    def succeeded(self) -> bool:
        x, y = self._ball
        return x > GOAL[0] + 0.05 and abs(y) < WIDTH
