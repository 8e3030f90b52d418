"""Four robots of examples/zones, one of which is killed in the corridor and started again."""

from __future__ import annotations

from typing import Protocol

NAMES = ("left_1", "left_2", "right_1", "right_2")
HOMES = dict(zip(NAMES, (1, 2, 6, 7), strict=True))


class Fleet(Protocol):
    """The robots, in a version of ROS."""

    def start(self, robot: str) -> None:
        """Start a robot, which listens to what it is told."""

    def kill(self, robot: str) -> None:
        """End it as a crash does."""

    def say(self, robot: str, what: str, value: int | bool) -> None:
        """Have it say this again and again, until something else."""

    def hears(self, robot: str, what: str, value: int) -> None:
        """Wait until it is told this anew."""

    def told(self, robot: str, what: str) -> set[int]:
        """All numbers that it was told."""

    def falls_silent(self, robot: str) -> None:
        """Wait until the controller shows that."""


def play(fleet: Fleet) -> None:
    def moves(robot: str, zone: int) -> None:
        fleet.hears(robot, "go", zone)
        fleet.say(robot, "zone", zone)

    def wishes(robot: str) -> None:
        fleet.say(robot, "wants", True)

    for robot in NAMES:
        fleet.start(robot)
        fleet.say(robot, "zone", HOMES[robot])
        fleet.say(robot, "wants", False)
    wishes("left_2")
    moves("left_2", 3)
    moves("left_2", 4)
    wishes("right_2")
    moves("right_2", 8)
    # The corridor is taken, from the other side.
    fleet.hears("right_2", "wait", 5)
    fleet.kill("left_2")
    fleet.falls_silent("left_2")
    # Its zones stay its own.
    fleet.hears("right_2", "wait", 5)
    assert 5 not in fleet.told("right_2", "go")
    fleet.start("left_2")
    fleet.say("left_2", "zone", 4)
    fleet.say("left_2", "wants", True)
    moves("left_2", 5)
    fleet.hears("left_2", "wait", 1)
    assert 1 not in fleet.told("left_2", "go")
    wishes("left_1")
    moves("left_1", 2)
    moves("left_2", 1)
    moves("right_2", 5)
    # Who comes to the corridor now, waits on its side.
    moves("left_1", 3)
    fleet.hears("left_1", "wait", 4)
    assert 4 not in fleet.told("left_1", "go")
    moves("right_2", 4)
    fleet.hears("right_2", "wait", 6)
    wishes("right_1")
    moves("right_1", 7)
    moves("right_2", 6)
    moves("left_1", 4)
