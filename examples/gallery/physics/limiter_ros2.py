"""The teleoperation as a node of ROS 2."""

import rclpy
from geometry_msgs.msg import Twist
from rclpy.node import Node
from rosgraph_msgs.msg import Clock
from std_msgs.msg import Empty
from teleoperation import Teleoperation

if __name__ == "__main__":
    rclpy.init()
    node = Node("teleoperation")
    pair = (
        node.create_publisher(type_, topic, 10)
        for topic, type_ in (("/cmd_vel", Twist), ("/alive", Empty))
    )
    law = Teleoperation(*pair, Twist, Empty)
    node.create_subscription(Clock, "/clock", law.drive, 10)
    rclpy.spin(node)
