"""The reckless line follower as a node of ROS 1."""

import rospy
from geometry_msgs.msg import Twist
from reckless import Reckless
from rosgraph_msgs.msg import Clock
from std_msgs.msg import Empty, Float32


def publisher(topic: str, type_: type) -> rospy.Publisher:
    return rospy.Publisher(topic, type_, queue_size=10, tcp_nodelay=True)


if __name__ == "__main__":
    rospy.init_node("reckless")
    law = Reckless(publisher("/cmd_vel", Twist), publisher("/alive", Empty))
    rospy.Subscriber("/line", Float32, law.look, tcp_nodelay=True)
    rospy.Subscriber("/clock", Clock, law.drive, tcp_nodelay=True)
    rospy.spin()
