"""A small robot on two wheels, with a laser scanner and a camera, as MuJoCo sees it."""

from __future__ import annotations

import math
from typing import Any

import mujoco
import numpy as np

__all__ = [
    "ODOMETRY", "RADIUS", "Camera", "Laser", "Rover", "body", "frame", "motors", "odometry", "wrap",
]  # fmt: skip

RADIUS = 0.1
"""Metres."""
WHEEL = 0.04
TRACK = 0.18
LASER_HEIGHT = 0.15


def frame(bodies: str, actuators: str, contacts: str = "") -> str:
    """Return a whole MuJoCo model around bodies and actuators: floor, light, time step."""
    return f"""<mujoco>
  <option timestep="0.005" integrator="implicitfast" {contacts}/>
  <visual>
    <global offwidth="480" offheight="360"/><quality shadowsize="0" offsamples="2"/>
    <headlight ambient=".4 .4 .4" diffuse=".15 .15 .15" specular="0 0 0"/>
  </visual>
  <worldbody>
    <light pos="0 0 6" dir="0 0 -1" directional="true" diffuse=".35 .35 .35"/>
    <geom name="floor" type="plane" size="6 6 .1" rgba=".8 .8 .75 1"/>
    {bodies}
  </worldbody>
  <actuator>{actuators}</actuator>
</mujoco>"""


def body(
    x: float, y: float, heading: float, name: str = "", rgba: str = ".2 .4 .8 1", extra: str = ""
) -> str:
    """Return a rover's body. Its own geoms are in group 1, which its laser does not see."""
    wheel = (
        '<body name="{n}{side}" pos="0 {y} 0"><joint name="{n}{side}" axis="0 1 0" damping=".001"/>'
        '<geom type="cylinder" size="{r} .012" euler="90 0 0" mass=".1" friction="1.5 .01 .001"'
        ' rgba=".1 .1 .1 1" group="1"/></body>'
    )
    wheels = "".join(
        wheel.format(n=name, side=side, y=y, r=WHEEL)
        for side, y in (("left", TRACK / 2), ("right", -TRACK / 2))
    )
    casters = "".join(
        f'<geom type="sphere" size=".018" pos="{at} 0 -.022" mass=".05" friction=".01 .001 .001"'
        ' priority="1" group="1"/>'
        for at in (0.075, -0.075)
    )
    return f"""
    <body name="{name}rover" pos="{x} {y} {WHEEL}" euler="0 0 {math.degrees(heading)}">
      <freejoint name="{name}rover"/>
      <geom name="{name}hull" type="cylinder" size="{RADIUS - 0.02} .03" pos="0 0 .03" mass="1.5"
            rgba="{rgba}" group="1"/>
      <geom type="cylinder" size=".03 .02" pos="0 0 .09" mass=".1" rgba=".1 .1 .1 1" group="1"/>
      <geom type="box" size=".01 .02 .01" pos=".07 0 .07" mass=".01" rgba="1 1 1 1" group="1"/>
      {casters}{wheels}{extra}
      <camera name="{name}camera" pos=".08 0 .16" xyaxes="0 -1 0 .6 0 .8" fovy="65"/>
    </body>"""


def motors(name: str = "") -> str:
    """Return a rover's actuators."""
    return "".join(
        f'<velocity name="{name}{side}" joint="{name}{side}" kv=".2" forcerange="-.6 .6"/>'
        for side in ("left", "right")
    )


class Rover:
    """Where a rover is, and how it is driven."""

    def __init__(self, model: Any, data: Any, name: str = "") -> None:
        self._body = data.body(f"{name}rover")
        self._wheels = [data.actuator(f"{name}{side}") for side in ("left", "right")]
        self.speed = 0.0
        self.turn = 0.0

    def drive(self, speed: float, turn: float) -> None:
        """Set the speeds, in m/s and rad/s."""
        self.speed, self.turn = speed, turn
        for wheel, side in zip(self._wheels, (-1.0, 1.0), strict=True):
            wheel.ctrl = (speed + side * turn * TRACK / 2) / WHEEL

    @property
    def position(self) -> tuple[float, float]:
        x, y, _ = self._body.xpos
        return float(x), float(y)

    @property
    def heading(self) -> float:
        matrix = self._body.xmat
        return math.atan2(matrix[3], matrix[0])

    def bearing(self, x: float, y: float) -> float:
        """Return the angle to a place, positive to the left."""
        own_x, own_y = self.position
        return wrap(math.atan2(y - own_y, x - own_x) - self.heading)

    def distance(self, x: float, y: float) -> float:
        own_x, own_y = self.position
        return math.hypot(x - own_x, y - own_y)


def wrap(angle: float) -> float:
    """Return an angle between -pi and pi."""
    return math.atan2(math.sin(angle), math.cos(angle))


ODOMETRY = "nav_msgs/Odometry"


def odometry(rover: Rover) -> dict[str, Any]:
    """Return where a rover is, as a message."""
    x, y = rover.position
    turned = {"z": math.sin(rover.heading / 2), "w": math.cos(rover.heading / 2)}
    pose = {"position": {"x": x, "y": y}, "orientation": turned}
    return {"header": {"frame_id": "odom"}, "pose": {"pose": pose}}


class Laser:
    """A scanner of 360 beams: the first to the front, counted to the left."""

    RANGE = 4.0
    TYPE = "sensor_msgs/LaserScan"

    def __init__(self, model: Any, data: Any, rover: Rover) -> None:
        self._model, self._data, self._rover = model, data, rover
        self._angles = np.radians(np.arange(360.0))
        # Not group 1, which is rovers, nor 2, which is what is only seen.
        self._groups = np.array([1, 0, 0, 1, 1, 1], dtype=np.uint8)
        self._hits = np.zeros(360, dtype=np.int32)
        self._ranges = np.zeros(360)

    def scan(self) -> dict[str, Any]:
        angles = self._angles + self._rover.heading
        beams = np.stack([np.cos(angles), np.sin(angles), np.zeros(360)], axis=1).ravel()
        x, y = self._rover.position
        mujoco.mj_multiRay(
            self._model, self._data, np.array([x, y, LASER_HEIGHT]), beams, self._groups, True, -1,
            self._hits, self._ranges, None, 360, self.RANGE,
        )  # fmt: skip
        ranges = np.where(self._hits >= 0, self._ranges, np.inf)
        return {
            "header": {"frame_id": "laser"},
            "angle_min": 0.0,
            "angle_max": 2 * math.pi,
            "angle_increment": math.radians(1.0),
            "range_min": RADIUS,
            "range_max": self.RANGE,
            "ranges": ranges.tolist(),
        }


class Camera:
    """The rover's camera: 64 by 32 pixels, looking forward and down."""

    def __init__(self, model: Any, data: Any, name: str = "camera") -> None:
        self._data, self._name = data, name
        self._renderer = mujoco.Renderer(model, 32, 64)
        self._renderer.scene.flags[mujoco.mjtRndFlag.mjRND_SHADOW] = 0
        self._renderer.scene.flags[mujoco.mjtRndFlag.mjRND_REFLECTION] = 0

    def picture(self) -> Any:
        """Return an array of 32 by 64 pixels of red, green and blue."""
        self._renderer.update_scene(self._data, camera=self._name)
        return self._renderer.render()

    def close(self) -> None:
        self._renderer.close()
