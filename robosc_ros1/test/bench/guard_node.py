"""Sends through the relay and through a supervisor in turn, and writes how long it took (JSON).

Arguments: "supervisor" or "limiter", samples of each, the file.
"""

import json
import sys
import threading
import time
from pathlib import Path

import rospy
from geometry_msgs.msg import Twist
from sensor_msgs.msg import LaserScan
from std_msgs.msg import Int16

WAYS = {
    "supervisor": {
        "relay": (Int16, "/relay_in", "/relay_out"),
        "supervisor": (Int16, "/supervised/blow", "/blow"),
    },
    "limiter": {
        "relay": (Twist, "/twist_in", "/twist_out"),
        "limiter": (Twist, "/supervised/cmd_vel", "/cmd_vel"),
    },
}
"""The type of the messages, the topic on which they go in, that on which they come out."""


class Way:
    """In at one topic, out at another."""

    def __init__(self, message_type, into, out):
        self.message = message_type()
        if message_type is Int16:
            self.message.data = 7
        else:  # so fast that it is corrected
            self.message.linear.x, self.message.angular.z = 1.0, 0.6
        self.publisher = rospy.Publisher(into, message_type, queue_size=10, tcp_nodelay=True)
        self.arrived = threading.Event()
        self.arrival = 0.0
        rospy.Subscriber(out, message_type, self.hear, tcp_nodelay=True)

    def hear(self, _):
        self.arrival = time.perf_counter()
        self.arrived.set()

    def measure(self):
        """Seconds; None if nothing came out."""
        self.arrived.clear()
        start = time.perf_counter()
        self.publisher.publish(self.message)
        return self.arrival - start if self.arrived.wait(2.0) else None


def sense():
    """What lets the commands pass: a level, and a laser ten times per second."""
    level = rospy.Publisher("/level", Int16, queue_size=10)
    scan = rospy.Publisher("/scan", LaserScan, queue_size=10, tcp_nodelay=True)
    seen = LaserScan(ranges=[3.0] * 360, range_min=0.1, range_max=10.0)
    rate = rospy.Rate(10)
    while not rospy.is_shutdown():
        level.publish(9)
        scan.publish(seen)
        rate.sleep()


def main():
    rospy.init_node("guard_latency")
    threading.Thread(target=sense, daemon=True).start()
    ways = {name: Way(*way) for name, way in WAYS[sys.argv[1]].items()}
    while any(way.measure() is None for way in ways.values()):
        pass  # not all is connected yet
    taken = {name: [] for name in ways}
    for _ in range(int(sys.argv[2])):
        for name, way in ways.items():
            taken[name].append(way.measure())
            time.sleep(0.002)
    with Path(sys.argv[3]).open("w", encoding="utf-8") as file:
        json.dump(taken, file)
    rospy.signal_shutdown("done")


main()
