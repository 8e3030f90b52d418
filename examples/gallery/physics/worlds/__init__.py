"""The worlds by name. A new one is a module here, and a row."""

from __future__ import annotations

from physics.world import World
from physics.worlds.ball import Ball
from physics.worlds.corridor import Corridor
from physics.worlds.follow_person import FollowPerson
from physics.worlds.follow_wall import FollowWall
from physics.worlds.go_to_pose import GoToPose
from physics.worlds.inspection import Inspection
from physics.worlds.limiter import Limiter
from physics.worlds.line_follower import LineFollower
from physics.worlds.maze import Maze
from physics.worlds.patrol import Patrol
from physics.worlds.pick_and_place import PickAndPlace

__all__ = ["WORLDS"]

WORLDS: dict[str, type[World]] = {
    "line_follower": LineFollower,
    "go_to_pose": GoToPose,
    "follow_wall": FollowWall,
    "maze": Maze,
    "ball": Ball,
    "follow_person": FollowPerson,
    "reckless": LineFollower,
    "pick_and_place": PickAndPlace,
    "corridor": Corridor,
    "limiter": Limiter,
    "patrol": Patrol,
    "inspection": Inspection,
}
