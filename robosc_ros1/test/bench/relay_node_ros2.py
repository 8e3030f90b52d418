"""The bare relay that a ROS 2 supervisor is compared with: what comes in goes out, read by nobody."""

import contextlib

import rclpy
from rclpy.executors import ExternalShutdownException
from std_msgs.msg import Float32

rclpy.init()
node = rclpy.create_node("bare_relay")
publisher = node.create_publisher(Float32, "relay_out", 10)
node.create_subscription(Float32, "relay_in", publisher.publish, 10, raw=True)
with contextlib.suppress(KeyboardInterrupt, ExternalShutdownException):
    rclpy.spin(node)
