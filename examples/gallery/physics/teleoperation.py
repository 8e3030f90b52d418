"""Somebody who steers at full speed, straight on and in curves, and looks at nothing.

It sends as often as the clock ticks. ``limiter_ros1.py`` and ``limiter_ros2.py`` are its nodes.
"""

from typing import Any

SPEED = 1.0
CURVES = (0.0, 2.0, 0.0, -2.0)
"""Radians per metre, one after another."""
TICKS = 40
"""So many ticks of the clock each."""


class Teleoperation:
    """The control law; ``wheels`` and ``alive`` publish what ``speeds`` and ``sign`` make."""

    def __init__(self, wheels: Any, alive: Any, speeds: Any, sign: Any) -> None:
        self._wheels, self._alive = wheels, alive
        self._speeds, self._sign = speeds, sign
        self._ticks = 0

    def drive(self, _: Any) -> None:
        twist = self._speeds()
        twist.linear.x = SPEED
        twist.angular.z = SPEED * CURVES[self._ticks // TICKS % len(CURVES)]
        self._ticks += 1
        self._wheels.publish(twist)
        self._alive.publish(self._sign())
