"""An arm that sorts parts by colour into two boxes, and a protective stop."""

from __future__ import annotations

import math
from collections.abc import Iterator
from typing import Any

import numpy as np

from physics.rover import frame
from physics.world import STEP, Sample, Task, World

__all__ = ["PickAndPlace"]

LINK = 0.25
PICK = (0.35, 0.0)
BOXES = {"red": (0.1, 0.38), "blue": (0.1, -0.38)}
PARTS = 3
TIMEOUT = 0.5
STOPPED = 2.0
SUCCESSFUL, GOAL_TOLERANCE_VIOLATED = 0, -5
JOINTS = ("shoulder", "elbow", "lift")
COLOURS = {"red": ".9 .15 .1 1", "blue": ".15 .3 .9 1"}
PART = """<body name="part{i}" pos="{x} 1.5 .02"><freejoint/>
  <geom name="part{i}" type="cylinder" size=".018 .02" mass=".05" rgba="{rgba}" condim="6"
        friction="2 .05 .01"/></body>"""
ARM = """
<geom type="cylinder" pos="0 0 .15" size=".05 .15" rgba=".3 .3 .3 1" contype="0" conaffinity="0"/>
<body name="upper" pos="0 0 .3"><joint name="shoulder" axis="0 0 1" damping="3"/>
  <geom type="capsule" fromto="0 0 0 .25 0 0" size=".03" mass=".6" rgba=".9 .6 .1 1" {ghost}/>
  <body name="fore" pos=".25 0 .03"><joint name="elbow" axis="0 0 1" damping="2"/>
    <geom type="capsule" fromto="0 0 0 .25 0 0" size=".025" mass=".4" rgba=".9 .6 .1 1" {ghost}/>
    <body name="hand" pos=".25 0 -.08"><joint name="lift" type="slide" axis="0 0 1" damping="20"/>
      <geom type="cylinder" pos="0 0 .06" size=".012 .1" mass=".1" rgba=".4 .4 .4 1" {ghost}/>
      <geom type="box" pos="0 0 -.03" size=".015 .05 .008" mass=".1" rgba=".3 .3 .3 1" {ghost}/>
      {fingers}
    </body></body></body>"""
GHOST = 'contype="0" conaffinity="0"'
FINGER = """<body pos="0 {y} -.06"><joint name="{name}" type="slide" axis="0 {axis} 0"
  range="0 .035" limited="true" damping="10"/><geom type="box" size=".012 .005 .03" mass=".03"
  rgba=".2 .2 .2 1" condim="6" friction="2 .05 .01"/></body>"""
ACTUATORS = """
<position name="shoulder" joint="shoulder" kp="120"/><position name="elbow" joint="elbow" kp="80"/>
<position name="lift" joint="lift" kp="800" forcerange="-60 60"/>
<position name="left" joint="left" kp="1500" forcerange="-15 15"/>
<position name="right" joint="right" kp="1500" forcerange="-15 15"/>"""


CONTACTS = 'cone="elliptic" impratio="10"'
"""Without these, what is held slips slowly."""


class PickAndPlace(World):
    seconds = 60.0
    sensors = {"/part": "std_msgs/String", "/protective_stop": "std_msgs/Bool"}
    commands = {"/alive": "std_msgs/Empty"}
    actions = {
        "/arm/follow_joint_trajectory": "control_msgs/FollowJointTrajectory",
        "/gripper/command": "control_msgs/GripperCommand",
    }
    view = {"distance": 1.5, "elevation": -35.0, "azimuth": 150.0, "lookat": (0.15, 0.0, 0.1)}

    def __init__(self, seed: int) -> None:
        super().__init__(seed)
        self._next = self._sorted = 0
        self._lying: int | None = None
        self._stop = self.random.uniform(3.0, 9.0)
        self.command_joints((0.0, 0.0, 0.0))
        self.command_fingers(0.035)
        self.observer.note(stopped=False)

    def xml(self) -> str:
        self._colours = [self.random.choice(("red", "blue")) for _ in range(PARTS)]
        parts = "".join(
            PART.format(i=i, x=0.2 * i, rgba=COLOURS[colour])
            for i, colour in enumerate(self._colours)
        )
        trays = "".join(
            f'<geom type="box" pos="{x} {y} .001" size=".07 .07 .001" rgba="{COLOURS[colour]}"'
            f" {GHOST}/>"
            for colour, (x, y) in BOXES.items()
        )
        fingers = FINGER.format(name="left", y=0.006, axis=1)
        fingers += FINGER.format(name="right", y=-0.006, axis=-1)
        return frame(parts + trays + ARM.format(ghost=GHOST, fingers=fingers), ACTUATORS, CONTACTS)

    # --- the cell ---

    def sense(self) -> Iterator[Sample]:
        stopped = self._stop <= self.time < self._stop + STOPPED
        self.observer.note(stopped=stopped)
        yield "/protective_stop", self.sensors["/protective_stop"], {"data": stopped}
        yield "/part", self.sensors["/part"], {"data": self._part_at_hand()}

    def _part_at_hand(self) -> str:
        """Return the colour of the part that lies ready.

        A sorted part is taken away when the hand has left it, and then the next one comes.
        """
        if self._lying is None and self._next < PARTS:
            self._lying, self._next = self._next, self._next + 1
            self._put(self._lying, PICK[0] + self.random.uniform(-0.008, 0.008), PICK[1])
        part = self._lying
        if part is None:
            return ""
        if self._is_sorted(part) and self.joints()[2] > -0.05:
            self._put(part, 0.2 * part, -1.5)
            self._sorted += 1
            self._lying = None
        return self._colours[part] if math.dist(self._where(part), PICK) < 0.05 else ""

    def _put(self, part: int, x: float, y: float) -> None:
        at = self.model.jnt_qposadr[self.model.body(f"part{part}").jntadr[0]]
        self.data.qpos[at : at + 7] = (x, y, 0.02, 1.0, 0.0, 0.0, 0.0)

    def _where(self, part: int) -> tuple[float, float]:
        x, y, _ = self.data.body(f"part{part}").xpos
        return float(x), float(y)

    def _is_sorted(self, part: int) -> bool:
        place = BOXES[self._colours[part]]
        low = float(self.data.body(f"part{part}").xpos[2]) < 0.04
        return low and math.dist(self._where(part), place) < 0.08

    # --- the arm ---

    def begin(self, action: str, request: Any) -> Task:
        self._judge()
        if action == "/gripper/command":
            return Grip(self, request.command.position)
        return Trajectory(self, request.trajectory)

    def _judge(self) -> None:
        self.observer.judge("moves only while not stopped", lambda m: not m["stopped"])
        self.observer.judge(
            "moves only if it sees", lambda m: all(m.fresh(t, TIMEOUT) for t in self.sensors)
        )

    def command(self, topic: str, message: Any) -> None:
        """Take a sign of life, which is all that is sent but goals."""

    def command_joints(self, positions: Any) -> None:
        for name, position in zip(JOINTS, positions, strict=True):
            self.data.actuator(name).ctrl = position

    def joints(self) -> Any:
        return np.array([float(self.data.joint(name).qpos[0]) for name in JOINTS])

    def command_fingers(self, width: float) -> None:
        for name in ("left", "right"):
            self.data.actuator(name).ctrl = width

    def fingers(self) -> float:
        return float(self.data.joint("left").qpos[0])

    def watch(self) -> None:
        if self.busy:
            self._judge()
        for part, colour in enumerate(self._colours):
            wrong = next(place for name, place in BOXES.items() if name != colour)
            if math.dist(self._where(part), wrong) < 0.07:
                self.observer.violate("sorts by colour")

    def succeeded(self) -> bool:
        return self._sorted >= PARTS

    def place(self) -> tuple[float, float]:
        x, y, _ = self.data.body("hand").xpos
        return float(x), float(y)


class Trajectory:
    """Goes from point to point of a trajectory, in straight lines of the joints."""

    def __init__(self, world: PickAndPlace, trajectory: Any) -> None:
        self._world = world
        order = [list(trajectory.joint_names).index(name) for name in JOINTS]
        self._times = [0.0, *(seconds(point.time_from_start) for point in trajectory.points)]
        points = [[point.positions[i] for i in order] for point in trajectory.points]
        self._points = np.array([world.joints(), *points])
        self._passed = 0.0

    def step(self) -> bool | None:
        self._passed += STEP
        self._world.command_joints(self._desired())
        if self._passed < self._times[-1] + 0.2:
            return None
        return self._is_there()

    def _desired(self) -> Any:
        return np.array([np.interp(self._passed, self._times, column) for column in self._points.T])

    def _is_there(self) -> bool:
        return bool(np.abs(self._world.joints() - self._points[-1]).max() < 0.05)

    def feedback(self) -> dict[str, Any]:
        desired, actual = self._desired(), self._world.joints()
        points = {"desired": desired, "actual": actual, "error": desired - actual}
        return {
            "joint_names": list(JOINTS),
            **{name: {"positions": joints.tolist()} for name, joints in points.items()},
        }

    def result(self) -> dict[str, Any]:
        return {"error_code": SUCCESSFUL if self._is_there() else GOAL_TOLERANCE_VIOLATED}

    def stop(self) -> None:
        self._world.command_joints(self._world.joints())


class Grip:
    """Moves the fingers to a width, or against what lies between them."""

    def __init__(self, world: PickAndPlace, position: float) -> None:
        self._world, self._position = world, position
        self._passed = 0.0

    def step(self) -> bool | None:
        self._passed += STEP
        self._world.command_fingers(self._position)
        return None if self._passed < 0.6 else True

    def feedback(self) -> dict[str, Any]:
        return self.result()

    def result(self) -> dict[str, Any]:
        position = self._world.fingers()
        arrived = abs(position - self._position) < 0.003
        stalled = not arrived and self._passed >= 0.6
        return {"position": position, "stalled": stalled, "reached_goal": arrived}

    def stop(self) -> None:
        """What is held stays held."""


def seconds(duration: Any) -> float:
    """Return a duration of either version of ROS in seconds."""
    return float(
        duration.to_sec() if hasattr(duration, "to_sec") else duration.sec + duration.nanosec * 1e-9
    )
