"""The robot of the example on ROS 2: floor, drive, sensors, grabber and light.

Start it with ``python3 simulated_robot_ros2.py``. Parameters: speed (simulated seconds per second),
seed, failure (share of grabs that fail), listeners (nodes that must listen to /distance, one of
them to all topics, before the first measurement is sent), awaits_switch (whether the light is to be
switched before).
"""

import contextlib
import random
import sys
import threading
import time
from pathlib import Path

import rclpy
from geometry_msgs.msg import Pose2D, Twist
from rclpy.action import ActionServer, CancelResponse
from rclpy.callback_groups import ReentrantCallbackGroup
from rclpy.executors import ExternalShutdownException, MultiThreadedExecutor
from rclpy.node import Node
from rclpy.qos import DurabilityPolicy, QoSProfile
from robot_common.action import Grabber
from robot_common.srv import LightBulbService
from std_msgs.msg import Bool, Empty, Float32

sys.path.insert(0, str(Path(__file__).resolve().parents[1] / "src"))

from line_follower.world import World, standard_track

RATE = 50.0
"""Steps per second of wall time."""
GRAB_SECONDS = 2.0
FOLD_SECONDS = 0.4
"""For this long after a grab the arm is still in front of the distance sensor."""


class SimulatedRobot(Node):
    def __init__(self):
        super().__init__("simulated_robot")
        self.speed = self.declare_parameter("speed", 1.0).value
        self.failure = self.declare_parameter("failure", 0.35).value
        self.listeners = self.declare_parameter("listeners", 0).value
        self.awaits_switch = self.declare_parameter("awaits_switch", False).value
        self.is_switched = False
        self.random = random.Random(self.declare_parameter("seed", 1).value)
        self.world = World(standard_track())
        self.lock = threading.Lock()
        self.blind = self.touched = self.begun = False
        self.distance = self.create_publisher(Float32, "/distance", 10)
        self.correction = self.create_publisher(Float32, "/correction", 10)
        self.no_line = self.create_publisher(Empty, "/no_line", 10)
        self.pose = self.create_publisher(Pose2D, "/pose", 10)
        latched = QoSProfile(depth=1, durability=DurabilityPolicy.TRANSIENT_LOCAL)
        self.light = self.create_publisher(Bool, "/light", latched)
        self.bump = self.create_publisher(Empty, "/bump", 10)
        self.create_subscription(Twist, "/vel", self.on_velocity, 10)
        self.create_service(LightBulbService, "/set_light_state", self.on_light)
        self.server = ActionServer(
            self,
            Grabber,
            "/grab",
            self.on_grab,
            cancel_callback=lambda _: CancelResponse.ACCEPT,
            callback_group=ReentrantCallbackGroup(),
        )
        self.create_timer(1 / RATE, self.step)

    def on_velocity(self, message):
        with self.lock:
            self.world.robot.command(message.linear.x, message.angular.z)

    def on_light(self, request, response):
        self.light.publish(Bool(data=request.state))
        self.is_switched = True
        return response

    def on_grab(self, goal):
        # The arm is in front of the distance sensor from now on, which then measures nothing.
        self.blind = True
        try:
            ended = time.monotonic() + GRAB_SECONDS / self.speed
            while time.monotonic() < ended:
                if goal.is_cancel_requested:
                    goal.canceled()
                    return Grabber.Result()
                time.sleep(0.02)
            missed = self.random.random() < self.failure
            with self.lock:
                held = not missed and self.world.grab()
            if held:
                goal.succeed()
            else:
                goal.abort()
            return Grabber.Result()
        finally:
            threading.Timer(FOLD_SECONDS / self.speed, self.fold).start()

    def fold(self):
        self.blind = False

    def is_heard(self):
        """Whether enough nodes listen to /distance, and at least one to whatever else is sent."""
        others = (self.correction, self.no_line, self.pose, self.light, self.bump)
        return not self.listeners or (
            self.distance.get_subscription_count() >= self.listeners
            and all(topic.get_subscription_count() for topic in others)
        )

    def step(self):
        is_lit = self.is_switched or not self.awaits_switch
        self.begun = self.begun or (is_lit and self.is_heard())
        if not self.begun:
            return
        with self.lock:
            self.world.step(self.speed / RATE)
            pose = self.world.robot.pose
            distance, correction = self.world.distance(), self.world.correction()
            touched = self.world.touched
        self.pose.publish(Pose2D(x=pose.x, y=pose.y, theta=pose.heading))
        if not self.blind:
            self.distance.publish(Float32(data=distance))
        if correction is None:
            self.no_line.publish(Empty())
        else:
            self.correction.publish(Float32(data=correction))
        if touched and not self.touched:
            self.bump.publish(Empty())
        self.touched = touched


if __name__ == "__main__":
    rclpy.init()
    executor = MultiThreadedExecutor(num_threads=4)
    executor.add_node(SimulatedRobot())
    with contextlib.suppress(KeyboardInterrupt, ExternalShutdownException):
        executor.spin()
