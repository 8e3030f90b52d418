"""The simulated world of the line follower: a line can be followed, obstacles are met."""

from __future__ import annotations

import math

from line_follower.world import (
    FAR,
    OBSTACLES,
    Pose,
    Robot,
    World,
    standard_track,
)

STEP = 0.02


def test_robot_goes_straight_and_turns_left_for_a_positive_rate() -> None:
    robot = Robot(Pose(0.0, 0.0, 0.0))
    robot.command(0.4, 0.0)
    for _ in range(50):
        robot.step(STEP)
    assert robot.pose.x > 0.2
    assert robot.pose.y == 0.0
    robot.command(0.4, 0.5)
    for _ in range(50):
        robot.step(STEP)
    assert robot.pose.heading > 0.4
    assert robot.pose.y > 0.0


def test_robot_halts_when_commands_cease() -> None:
    robot = Robot(Pose(0.0, 0.0, 0.0))
    robot.command(0.4, 0.0)
    for _ in range(500):
        robot.step(STEP)
    assert robot.speed == 0.0


def test_correction_is_positive_when_the_line_is_to_the_left() -> None:
    world = World(standard_track(), obstacles=())
    start = world.track.at(1.5)
    right = Pose(start.x + 0.05 * math.sin(start.heading), start.y - 0.05, start.heading)
    world.robot.pose = right
    world._arc = 1.5
    world.step(STEP)
    correction = world.correction()
    assert correction is not None
    assert 0.0 < correction < 60.0


def test_careful_driver_makes_a_lap_and_touches_nothing() -> None:
    """Steers by the correction, halts and grabs at each obstacle, crosses the gap."""
    world = World(standard_track())
    driven, grabs, gap = 0.0, 0, 0
    for _ in range(int(90 / STEP)):
        correction, distance = world.correction(), world.distance()
        gap += correction is None
        if distance < 0.35:
            world.robot.command(0.0, 0.0)
            if world.robot.speed == 0.0:
                grabs += world.grab()
        else:
            world.robot.command(*((0.2, 0.0) if correction is None else (0.4, correction / 100)))
        world.step(STEP)
        driven += world.robot.speed * STEP
        assert not world.touched
        if driven > world.track.length:
            break
    assert driven > world.track.length
    assert grabs == len(OBSTACLES)
    assert gap > 0


def test_careless_driver_runs_into_an_obstacle() -> None:
    world = World(standard_track())
    for _ in range(int(30 / STEP)):
        correction = world.correction()
        world.robot.command(*((0.2, 0.0) if correction is None else (0.4, correction / 100)))
        world.step(STEP)
    assert world.touched


def test_grab_needs_something_within_reach() -> None:
    world = World(standard_track())
    assert world.distance() == FAR
    assert not world.grab()
