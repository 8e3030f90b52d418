"""The bare relays that generated nodes are compared with: what comes in goes out."""

import rospy
from geometry_msgs.msg import Twist
from std_msgs.msg import Int16

rospy.init_node("bare_relay")
publisher = rospy.Publisher("/relay_out", Int16, queue_size=10, tcp_nodelay=True)
rospy.Subscriber("/relay_in", Int16, publisher.publish, tcp_nodelay=True)
twists = rospy.Publisher("/twist_out", Twist, queue_size=10, tcp_nodelay=True)
rospy.Subscriber("/twist_in", Twist, twists.publish, tcp_nodelay=True)
rospy.spin()
