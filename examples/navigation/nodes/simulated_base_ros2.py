"""The robot of the example on ROS 2: the action /navigate, its place on /pose, and ten times a
second on /emergency_stop whether its emergency stop is pressed, which /press does.

Start it with ``python3 simulated_base_ros2.py``. Parameters: speed (simulated seconds per second),
failures (so many drives fail first).
"""

import contextlib
import sys
import time
from pathlib import Path

import rclpy
from geometry_msgs.msg import Pose2D
from rclpy.action import ActionServer, CancelResponse
from rclpy.callback_groups import ReentrantCallbackGroup
from rclpy.executors import ExternalShutdownException, MultiThreadedExecutor
from rclpy.node import Node
from robot_common.action import Navigate
from std_msgs.msg import Bool

sys.path.insert(0, str(Path(__file__).resolve().parents[1] / "src"))

from navigation_example.base import Base, Drive

STEP = 0.02
"""Seconds."""


class SimulatedBase(Node):
    def __init__(self):
        super().__init__("simulated_base")
        self.speed = self.declare_parameter("speed", 1.0).value
        self.failures = self.declare_parameter("failures", 0).value
        self.base = Base()
        self.pressed = False
        self.pose = self.create_publisher(Pose2D, "/pose", 10)
        self.stop = self.create_publisher(Bool, "/emergency_stop", 10)
        self.create_subscription(Bool, "/press", self.press, 10)
        self.create_timer(0.1, lambda: self.stop.publish(Bool(data=self.pressed)))
        self.server = ActionServer(
            self,
            Navigate,
            "/navigate",
            self.drive,
            cancel_callback=lambda _: CancelResponse.ACCEPT,
            callback_group=ReentrantCallbackGroup(),
        )

    def press(self, message):
        self.pressed = message.data
        self.stop.publish(message)

    def drive(self, goal):
        self.get_logger().info(f"driving to {goal.request.x:g}, {goal.request.y:g}")
        drive = Drive(self.base, goal.request.x, goal.request.y, self.failures)
        self.failures -= 1
        ended = None
        while ended is None:
            time.sleep(STEP)
            if goal.is_cancel_requested:
                self.get_logger().info(f"stopped at {self.base.x:.1f}, {self.base.y:.1f}")
                goal.canceled()
                return Navigate.Result()
            left, ended = drive.step(STEP * self.speed)
            self.pose.publish(Pose2D(x=self.base.x, y=self.base.y))
            goal.publish_feedback(Navigate.Feedback(distance=left))
        self.get_logger().info(f"{ended} at {self.base.x:.1f}, {self.base.y:.1f}")
        if ended == "arrived":
            goal.succeed()
        else:
            goal.abort()
        return Navigate.Result(distance=left)


def main():
    rclpy.init()
    executor = MultiThreadedExecutor(num_threads=4)
    executor.add_node(SimulatedBase())
    with contextlib.suppress(KeyboardInterrupt, ExternalShutdownException):
        executor.spin()


main()
