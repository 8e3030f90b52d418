"""A line follower as one writes it in a hurry. It stops for nothing.

It sends as often as the clock ticks, and never looks at the emergency stop or at the age of what
the camera said last. ``reckless_ros1.py`` and ``reckless_ros2.py`` are its nodes.
"""

import math

from geometry_msgs.msg import Twist
from rosgraph_msgs.msg import Clock
from std_msgs.msg import Empty, Float32


class Reckless:
    """The control law; ``wheels`` and ``alive`` publish what it sends."""

    def __init__(self, wheels, alive) -> None:
        self.offset = 0.0
        self.wheels = wheels
        self.alive = alive

    def look(self, message: Float32) -> None:
        if not math.isnan(message.data):
            self.offset = message.data

    def drive(self, _: Clock) -> None:
        twist = Twist()
        twist.linear.x = 0.3 - 0.2 * abs(self.offset)
        twist.angular.z = 2.0 * self.offset
        self.wheels.publish(twist)
        self.alive.publish(Empty())
