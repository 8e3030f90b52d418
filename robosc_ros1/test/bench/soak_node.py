"""Measures nodes for a long time on either ROS, and writes how long each message took (JSON).

Arguments: the version of ROS, seconds, "listen" to what the nodes show or not, the file. A scan of
360 numbers goes to all nodes 20 times per second; between the scans, messages go through the relay
and the nodes in turn.
"""

import importlib
import json
import sys
import threading
import time
from pathlib import Path

from std_msgs.msg import Float32, Float32MultiArray, Int16, String

SCANS = 20.0
"""Per second, with a message for each node and the relay between two of them."""
NODES = {
    "controller": (Int16, "/controller/level", "/controller/blow", "/controller/halt"),
    "supervisor": (Int16, "/supervisor/supervised/blow", "/supervisor/blow"),
}
RELAYS = {
    "1": {"relay": (Int16, "/relay_in", "/relay_out")},
    "2": {
        "relay": (Int16, "/echo_in", "/echo_out"),
        "relay of bytes": (Float32, "/relay_in", "/relay_out"),
    },
}
"""The type of the messages, the topic on which they go in, those on which they come out."""


class Ros1:
    def __init__(self):
        self.rospy = importlib.import_module("rospy")
        self.rospy.init_node("soak")

    def publisher(self, topic, type_):
        return self.rospy.Publisher(topic, type_, queue_size=10, tcp_nodelay=True)

    def listen(self, topic, type_, hear):
        self.rospy.Subscriber(topic, type_, hear, tcp_nodelay=True)

    def end(self):
        self.rospy.signal_shutdown("done")


class Ros2:
    def __init__(self):
        rclpy = importlib.import_module("rclpy")
        self.spinning = importlib.import_module("measuring_ros2").spinning
        rclpy.init()
        self.node = rclpy.create_node("soak")

    def publisher(self, topic, type_):
        return self.node.create_publisher(type_, topic, 10)

    def listen(self, topic, type_, hear):
        self.node.create_subscription(type_, topic, hear, 10)

    def begin(self):
        self.thread = self.spinning(self.node)
        self.thread.__enter__()

    def end(self):
        self.thread.__exit__(None, None, None)


class Way:
    """In at one topic, out at another."""

    def __init__(self, ros, type_, into, *outs):
        self.type = type_
        self.publisher = ros.publisher(into, type_)
        self.arrived = threading.Event()
        self.arrival = 0.0
        for out in outs:
            ros.listen(out, type_, self.hear)

    def hear(self, _):
        self.arrival = time.perf_counter()
        self.arrived.set()

    def measure(self, value):
        """Seconds; None if nothing came out."""
        self.arrived.clear()
        start = time.perf_counter()
        self.publisher.publish(self.type(data=self.type().data + value))
        return self.arrival - start if self.arrived.wait(2.0) else None


def main():
    ros = Ros1() if sys.argv[1] == "1" else Ros2()
    ways = {name: Way(ros, *way) for name, way in (RELAYS[sys.argv[1]] | NODES).items()}
    scan = ros.publisher("/scan", Float32MultiArray)
    level = ros.publisher("/supervisor/level", Int16)
    shown = {"state": 0, "events": 0}

    def count(part):
        return lambda _: shown.update({part: shown[part] + 1})

    if sys.argv[3] == "listen":
        for node in NODES:
            for part in shown:
                ros.listen(f"/{node}/soak_{node}/{part}", String, count(part))
    if sys.argv[1] == "2":
        ros.begin()
    beams = Float32MultiArray(data=[0.5 + n / 360 for n in range(360)])

    def connect(way, value):
        scan.publish(beams)
        level.publish(Int16(data=9))
        return way.measure(value) is not None

    for way in ways.values():
        while not all(connect(way, value) for value in (3, 9)):
            pass
    names = list(ways)
    taken = {name: [] for name in ways}
    start = time.perf_counter()
    for number in range(int(float(sys.argv[2]) * SCANS)):
        scan.publish(beams)
        time.sleep(0.2 / SCANS)
        # The first one finds caches that the scan has left, so each is that in turn.
        names.append(names.pop(0))
        for name in names:
            # The level changes sides each time, so that each message enables another command.
            taken[name].append(ways[name].measure(3 if number % 2 else 9))
            time.sleep(0.002)
        time.sleep(max(0.0, start + (number + 1) / SCANS - time.perf_counter()))
    with Path(sys.argv[4]).open("w", encoding="utf-8") as file:
        json.dump({"latencies": taken, "shown": shown}, file)
    ros.end()


main()
