"""The reckless line follower for ROS 2."""

import math

import rclpy
from geometry_msgs.msg import Twist
from rclpy.node import Node
from rosgraph_msgs.msg import Clock
from std_msgs.msg import Empty, Float32


class Reckless(Node):
    def __init__(self) -> None:
        super().__init__("reckless")
        self.offset = 0.0
        self.wheels = self.create_publisher(Twist, "/cmd_vel", 10)
        self.alive = self.create_publisher(Empty, "/alive", 10)
        self.create_subscription(Float32, "/line", self.look, 10)
        self.create_subscription(Clock, "/clock", self.drive, 10)

    def look(self, message: Float32) -> None:
        if not math.isnan(message.data):
            self.offset = message.data

    def drive(self, _: Clock) -> None:
        twist = Twist()
        twist.linear.x = 0.3 - 0.2 * abs(self.offset)
        twist.angular.z = 2.0 * self.offset
        self.wheels.publish(twist)
        self.alive.publish(Empty())


if __name__ == "__main__":
    rclpy.init()
    rclpy.spin(Reckless())
