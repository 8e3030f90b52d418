"""The worlds by name. A new one is a module here, and a row."""

from __future__ import annotations

from physics.world import World
from physics.worlds.ball import Ball
from physics.worlds.follow_person import FollowPerson
from physics.worlds.follow_wall import FollowWall
from physics.worlds.go_to_pose import GoToPose
from physics.worlds.line_follower import LineFollower
from physics.worlds.maze import Maze

__all__ = ["WORLDS"]

WORLDS: dict[str, type[World]] = {
    "line_follower": LineFollower,
    "go_to_pose": GoToPose,
    "follow_wall": FollowWall,
    "maze": Maze,
    "ball": Ball,
    "follow_person": FollowPerson,
    "reckless": LineFollower,
}
