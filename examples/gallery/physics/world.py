"""What the worlds have in common: a MuJoCo model, topics, action servers, an observer."""

from __future__ import annotations

import random
from collections.abc import Iterator
from typing import Any, ClassVar, Protocol

import mujoco

from physics.observer import Observer

__all__ = ["STEP", "Sample", "Task", "World"]

STEP = 0.05
"""Seconds of simulated time between two exchanges with the controller."""

Sample = tuple[str, str, dict[str, Any]]
"""What is published: topic, type and fields."""


class Task(Protocol):
    """What an action server does for one goal."""

    def step(self) -> bool | None:
        """Go on for one step; how it ended (True: succeeded), None while it lasts."""

    def feedback(self) -> dict[str, Any]:
        """Return the fields of the feedback."""

    def result(self) -> dict[str, Any]:
        """Return the fields of the result."""

    def stop(self) -> None:
        """Leave it unfinished."""


class World:
    """A world to be subclassed. ``seed`` decides what it looks like."""

    seconds: ClassVar[float] = 20.0
    """How long a run lasts at most, in simulated time."""
    sensors: ClassVar[dict[str, str]] = {}
    """Topics that the robot publishes all the time, with their types; faults silence them."""
    buttons: ClassVar[dict[str, str]] = {}
    """Topics that are published now and then."""
    commands: ClassVar[dict[str, str]] = {}
    """Topics that the controller commands the robot on."""
    actions: ClassVar[dict[str, str]] = {}
    """Actions that the robot serves."""
    view: ClassVar[dict[str, Any]] = {"distance": 6.0, "elevation": -55.0, "azimuth": 90.0}
    """Where the film is taken from."""

    def __init__(self, seed: int) -> None:
        self.random = random.Random(seed)
        self.time = 0.0
        self.busy: frozenset[str] = frozenset()
        """The actions that have a goal."""
        self.observer = Observer()
        self.observer.note(busy=self.busy)
        self.model = mujoco.MjModel.from_xml_string(self.xml())
        self.data = mujoco.MjData(self.model)
        mujoco.mj_forward(self.model, self.data)

    # --- what a world says of itself ---

    def xml(self) -> str:
        """Return the MuJoCo model."""
        raise NotImplementedError

    def control(self) -> None:
        """Set the actuators, before each step."""

    def sense(self) -> Iterator[Sample]:
        """Yield what the sensors and buttons publish after a step."""
        raise NotImplementedError

    def command(self, topic: str, message: Any) -> None:
        """Take a command, and judge it."""
        raise NotImplementedError

    def begin(self, action: str, request: Any) -> Task:
        """Take a goal, and judge it."""
        raise NotImplementedError

    def watch(self) -> None:
        """Tell the observer what is true after a step."""

    def succeeded(self) -> bool:
        """Whether the task is done; the run ends then."""
        raise NotImplementedError

    def place(self) -> tuple[float, float]:
        """Return where the robot is, for the picture of the path."""
        raise NotImplementedError

    # --- what the bridge does ---

    def step(self) -> None:
        """Let ``STEP`` seconds pass."""
        self.control()
        for _ in range(round(STEP / self.model.opt.timestep)):
            mujoco.mj_step(self.model, self.data)
        self.time = round(self.time + STEP, 6)
        self.observer.tick(self.time)
        self.observer.note(busy=self.busy)
        self.watch()

    def close(self) -> None:
        """Give back what the operating system holds for the world."""
