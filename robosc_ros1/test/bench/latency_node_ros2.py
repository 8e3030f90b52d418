"""Sends through a relay and through a generated node in turn, and writes how long it took (JSON).

Arguments: "supervisor", "controller" or "limiter", samples of each, the file.
"""

import sys
import threading
import time

import rclpy
from geometry_msgs.msg import Twist
from measuring_ros2 import spinning, write
from std_msgs.msg import Float32, Int16

WAYS = {
    "supervisor": {
        "relay": (Float32, "relay_in", "relay_out"),
        "supervisor": (Float32, "supervised/speed", "speed"),
    },
    "controller": {
        "relay": (Int16, "echo_in", "echo_out"),
        "controller": (Int16, "level", "blow", "halt"),
    },
    "limiter": {
        "relay": (Twist, "twist_in", "twist_out"),
        "limiter": (Twist, "supervised/cmd_vel", "cmd_vel"),
    },
}
"""The type of the messages, the topic on which they go in, those on which they come out."""


class Way:
    """In at one topic, out at another."""

    def __init__(self, node, message_type, into, *outs):
        self.type = message_type
        self.publisher = node.create_publisher(message_type, into, 10)
        self.arrived = threading.Event()
        self.arrival = 0.0
        for out in outs:
            node.create_subscription(message_type, out, self.hear, 10)

    def hear(self, _):
        self.arrival = time.perf_counter()
        self.arrived.set()

    def measure(self, number):
        """Seconds; None if nothing came out."""
        message = self.type()
        if self.type is Twist:  # so fast that it is corrected
            message.linear.x, message.angular.z = 1.0, 0.6
        else:  # the level changes sides each time, so that each message enables another command
            message.data += 3 if number % 2 else 9
        self.arrived.clear()
        start = time.perf_counter()
        self.publisher.publish(message)
        return self.arrival - start if self.arrived.wait(2.0) else None


def sense(node):
    """What lets a limiter pass commands: the distance ahead, ten times per second."""
    publisher = node.create_publisher(Float32, "scan", 10)
    node.create_timer(0.1, lambda: publisher.publish(Float32(data=3.0)))


def main():
    rclpy.init()
    node = rclpy.create_node("latency")
    sense(node)
    ways = {name: Way(node, *way) for name, way in WAYS[sys.argv[1]].items()}
    with spinning(node):
        while any(way.measure(number) is None for way in ways.values() for number in (0, 1)):
            pass  # not all is connected yet
        taken = {name: [] for name in ways}
        for number in range(int(sys.argv[2])):
            for name, way in ways.items():
                taken[name].append(way.measure(number))
                time.sleep(0.002)
        write(taken, sys.argv[3])


main()
