"""A line follower as one writes it in a hurry, for ROS 1. It stops for nothing.

It sends as often as the clock ticks, and never looks at the emergency stop or at the age of what
the camera said last.
"""

import math

import rospy
from geometry_msgs.msg import Twist
from rosgraph_msgs.msg import Clock
from std_msgs.msg import Empty, Float32


class Reckless:
    def __init__(self) -> None:
        self.offset = 0.0
        self.wheels = rospy.Publisher("/cmd_vel", Twist, queue_size=10, tcp_nodelay=True)
        self.alive = rospy.Publisher("/alive", Empty, queue_size=10, tcp_nodelay=True)
        rospy.Subscriber("/line", Float32, self.look, tcp_nodelay=True)
        rospy.Subscriber("/clock", Clock, self.drive, tcp_nodelay=True)

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
    rospy.init_node("reckless")
    Reckless()
    rospy.spin()
