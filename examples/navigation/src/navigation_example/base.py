"""A mobile base on a floor without walls, and a drive of it to a place. No ROS in here."""

import math

__all__ = ["Base", "Drive"]

SPEED = 0.5
"""Metres per second."""


class Base:
    """Where the base is, in metres."""

    def __init__(self):
        self.x = 0.0
        self.y = 0.0

    def step(self, x, y, seconds):
        """Move towards a place; the distance that is left."""
        left = math.hypot(x - self.x, y - self.y)
        share = min(1.0, SPEED * seconds / left) if left > 0.0 else 0.0
        self.x += share * (x - self.x)
        self.y += share * (y - self.y)
        return left * (1.0 - share)


class Drive:
    """One goal. ``failures``: how many drives fail, this one included; halfway they get stuck, or,
    where the number is even, take that for the place."""

    def __init__(self, base, x, y, failures):
        self._base = base
        self._place = (x, y)
        self._failure = "stuck" if failures % 2 else "arrived"
        self._fails_at = math.hypot(x - base.x, y - base.y) / 2.0 if failures > 0 else -1.0

    def step(self, seconds):
        """What is left of the way, and how it ended: "arrived", "stuck", or None while it lasts."""
        left = self._base.step(*self._place, seconds)
        if left <= self._fails_at:
            return left, self._failure
        return left, "arrived" if left < 1e-6 else None
