"""The observer of the example on ROS 2: judges by what the topics say, and sums up.

Start it with ``python3 observer_ros2.py``. Parameters: metres (end after this way), seconds (end
after this time at the latest), tolerance (seconds that a message may be in flight), report (file
for the summary, JSON).
"""

import math
import sys
import time
from pathlib import Path

import rclpy
from action_msgs.msg import GoalStatus, GoalStatusArray
from geometry_msgs.msg import Pose2D, Twist
from rclpy.node import Node
from rclpy.qos import qos_profile_action_status_default
from std_msgs.msg import Bool, Empty, Float32

sys.path.insert(0, str(Path(__file__).resolve().parents[1] / "src"))

from line_follower.observed import Observed

STATUS = "/grab/_action/status"


class Observer(Node):
    def __init__(self):
        super().__init__("observer")
        self.metres = self.declare_parameter("metres", math.inf).value
        self.seconds = self.declare_parameter("seconds", math.inf).value
        self.report = self.declare_parameter("report", "").value
        observed = Observed(self.declare_parameter("tolerance", 0.1).value)
        judge, self.observed = observed.judge, observed
        self.running, self.ended = set(), set()
        others = (
            ("/correction", Float32, lambda now, _: judge.line(now, True)),
            ("/no_line", Empty, lambda now, _: judge.line(now, False)),
            ("/vel", Twist, lambda now, m: observed.velocity(now, m.linear.x, m.angular.z)),
            ("/light", Bool, lambda now, m: observed.light(now, m.data)),
            ("/bump", Empty, lambda now, _: judge.bump(now)),
            ("/pose", Pose2D, lambda _, m: observed.pose(m.x, m.y)),
        )
        for entry in others:
            self.hear(*entry)
        status = qos_profile_action_status_default
        self.hear(STATUS, GoalStatusArray, self.on_status, status)
        # The robot begins when this node listens to /distance: by then it hears all the others.
        topics = [STATUS, *(topic for topic, _, _ in others)]
        while rclpy.ok() and not all(map(self.count_publishers, topics)):
            rclpy.spin_once(self, timeout_sec=0.05)
        self.hear("/distance", Float32, lambda now, m: judge.distance(now, m.data))

    def hear(self, topic, kind, handler, profile=100):
        def heard(message, info):
            now, received = time.monotonic(), info["received_timestamp"]
            if received:
                self.observed.judge.late(now, time.time() - received * 1e-9)
            handler(now, message)

        self.create_subscription(kind, topic, heard, profile)

    def on_status(self, now, message):
        """Goals are requests of a service, which nobody else hears: their status tells of them."""
        for status in message.status_list:
            goal = bytes(status.goal_info.goal_id.uuid)
            if goal not in self.running | self.ended:
                self.running.add(goal)
                self.observed.goal(now, goal)
            over = status.status >= GoalStatus.STATUS_SUCCEEDED
            if over and goal in self.running:
                self.running.remove(goal)
                self.ended.add(goal)
                succeeded = status.status == GoalStatus.STATUS_SUCCEEDED
                self.observed.result(now, goal, succeeded)

    def run(self):
        end = time.monotonic() + self.seconds
        while rclpy.ok() and self.observed.metres < self.metres and time.monotonic() < end:
            rclpy.spin_once(self, timeout_sec=0.05)
            self.observed.judge.settle(time.monotonic())
        self.get_logger().info(self.observed.write(self.report))


if __name__ == "__main__":
    rclpy.init()
    Observer().run()
