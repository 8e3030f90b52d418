"""The teleoperation as a node of ROS 1."""

import rospy
from geometry_msgs.msg import Twist
from rosgraph_msgs.msg import Clock
from std_msgs.msg import Empty
from teleoperation import Teleoperation


def publisher(topic: str, type_: type) -> rospy.Publisher:
    return rospy.Publisher(topic, type_, queue_size=10, tcp_nodelay=True)


if __name__ == "__main__":
    rospy.init_node("teleoperation")
    pair = publisher("/cmd_vel", Twist), publisher("/alive", Empty)
    law = Teleoperation(*pair, Twist, Empty)
    rospy.Subscriber("/clock", Clock, law.drive, tcp_nodelay=True)
    rospy.spin()
