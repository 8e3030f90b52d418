"""Sends through the relay and through the supervisor in turn, and writes how long it took (JSON).

Arguments: samples of each, the file.
"""

import json
import sys
import threading
import time
from pathlib import Path

import rospy
from std_msgs.msg import Int16


class Way:
    """In at one topic, out at another."""

    def __init__(self, into, out):
        self.publisher = rospy.Publisher(into, Int16, queue_size=10, tcp_nodelay=True)
        self.arrived = threading.Event()
        self.arrival = 0.0
        rospy.Subscriber(out, Int16, self.hear, tcp_nodelay=True)

    def hear(self, _):
        self.arrival = time.perf_counter()
        self.arrived.set()

    def measure(self):
        """Seconds; None if nothing came out."""
        self.arrived.clear()
        start = time.perf_counter()
        self.publisher.publish(7)
        return self.arrival - start if self.arrived.wait(2.0) else None


def main():
    rospy.init_node("guard_latency")
    level = rospy.Publisher("/level", Int16, queue_size=10)
    ways = {"relay": Way("/relay_in", "/relay_out"), "supervisor": Way("/supervised/blow", "/blow")}
    while not all(p.get_num_connections() for p in [level, *(w.publisher for w in ways.values())]):
        time.sleep(0.01)
    time.sleep(1.0)
    level.publish(9)  # so that the command is allowed
    time.sleep(0.5)
    taken = {name: [] for name in ways}
    for _ in range(int(sys.argv[1])):
        for name, way in ways.items():
            taken[name].append(way.measure())
            time.sleep(0.002)
    with Path(sys.argv[2]).open("w", encoding="utf-8") as file:
        json.dump(taken, file)
    rospy.signal_shutdown("done")


main()
