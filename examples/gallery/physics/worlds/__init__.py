"""The worlds by name. A new one is a module here, and a row."""

from __future__ import annotations

from physics.world import World
from physics.worlds.line_follower import LineFollower

__all__ = ["WORLDS"]

WORLDS: dict[str, type[World]] = {"line_follower": LineFollower}
