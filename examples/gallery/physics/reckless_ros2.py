"""The reckless line follower as a node of ROS 2."""

import rclpy
from geometry_msgs.msg import Twist
from rclpy.node import Node
from reckless import Reckless
from rosgraph_msgs.msg import Clock
from std_msgs.msg import Empty, Float32

if __name__ == "__main__":
    rclpy.init()
    node = Node("reckless")
    wheels, alive = (
        node.create_publisher(type_, topic, 10)
        for topic, type_ in (("/cmd_vel", Twist), ("/alive", Empty))
    )
    law = Reckless(wheels, alive)
    node.create_subscription(Float32, "/line", law.look, 10)
    node.create_subscription(Clock, "/clock", law.drive, 10)
    rclpy.spin(node)
