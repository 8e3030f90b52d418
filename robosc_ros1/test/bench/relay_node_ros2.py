"""The bare relays that generated ROS 2 nodes are compared with: what comes in goes out.

A supervisor passes bytes on, a controller and a limiter read what they get; so do these.
"""

import contextlib

import rclpy
from geometry_msgs.msg import Twist
from rclpy.executors import ExternalShutdownException
from std_msgs.msg import Float32, Int16

rclpy.init()
node = rclpy.create_node("bare_relay")
passing = node.create_publisher(Float32, "relay_out", 10)
node.create_subscription(Float32, "relay_in", passing.publish, 10, raw=True)
echoing = node.create_publisher(Int16, "echo_out", 10)
node.create_subscription(Int16, "echo_in", echoing.publish, 10)
limiting = node.create_publisher(Twist, "twist_out", 10)
node.create_subscription(Twist, "twist_in", limiting.publish, 10)
with contextlib.suppress(KeyboardInterrupt, ExternalShutdownException):
    rclpy.spin(node)
