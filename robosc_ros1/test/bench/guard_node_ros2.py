"""Sends through the relay and through the supervisor in turn, and writes how long it took (JSON).

Arguments: samples of each, the file.
"""

import contextlib
import json
import sys
import threading
import time
from pathlib import Path

import rclpy
from rclpy.executors import ExternalShutdownException
from std_msgs.msg import Float32


class Way:
    """In at one topic, out at another."""

    def __init__(self, node, into, out):
        self.publisher = node.create_publisher(Float32, into, 10)
        self.arrived = threading.Event()
        self.arrival = 0.0
        node.create_subscription(Float32, out, self.hear, 10)

    def hear(self, _):
        self.arrival = time.perf_counter()
        self.arrived.set()

    def measure(self):
        """Seconds; None if nothing came out."""
        self.arrived.clear()
        start = time.perf_counter()
        self.publisher.publish(Float32(data=7.0))
        return self.arrival - start if self.arrived.wait(2.0) else None


def main():
    rclpy.init()
    node = rclpy.create_node("guard_latency")
    ways = {
        "relay": Way(node, "relay_in", "relay_out"),
        "guard": Way(node, "supervised/speed", "speed"),
    }
    spinning = threading.Thread(target=spin, args=(node,), daemon=True)
    spinning.start()
    while any(way.measure() is None for way in ways.values()):
        pass  # not all is connected yet
    taken = {name: [] for name in ways}
    for _ in range(int(sys.argv[1])):
        for name, way in ways.items():
            taken[name].append(way.measure())
            time.sleep(0.002)
    with Path(sys.argv[2]).open("w", encoding="utf-8") as file:
        json.dump(taken, file)
    rclpy.try_shutdown()
    spinning.join()


def spin(node):
    with contextlib.suppress(ExternalShutdownException):
        rclpy.spin(node)


main()
