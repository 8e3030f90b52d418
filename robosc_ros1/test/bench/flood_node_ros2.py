"""Floods the generated controller, and writes what it received and how soon it answered (JSON).

Arguments: seconds, messages per second, the file. A hundredth of the messages enable a command, and
the time to that is measured.
"""

import json
import sys
import time

import rclpy
from measuring_ros2 import spinning, write
from rclpy.qos import DurabilityPolicy, QoSProfile
from robosc_testing.msg import Reading
from std_msgs.msg import Empty, Int16, String

NODE = "guarded_arm_controller"


class Flood:
    def __init__(self, node):
        self.readings = node.create_publisher(Reading, "person", 1000)
        self.charges = node.create_publisher(Int16, "charge", 1000)
        self.inputs = -1
        self.arrival = 0.0
        latched = QoSProfile(depth=1, durability=DurabilityPolicy.TRANSIENT_LOCAL)
        node.create_subscription(String, NODE + "/state", self.on_state, latched)
        node.create_subscription(Empty, "beacon", self.on_beacon, 10)

    def on_state(self, message):
        self.inputs = json.loads(message.data)["counters"]["inputs"]

    def on_beacon(self, _):
        self.arrival = time.perf_counter()

    def await_controller(self):
        """Send of both sorts until something arrives, for a match has two sides."""
        far, idle = Reading(valid=True, distance=5.0), Int16(data=0)
        for publisher, message in ((self.readings, far), (self.charges, idle)):
            before = self.inputs
            while self.inputs < 0 or self.inputs == before:
                publisher.publish(message)
                time.sleep(0.2)
        time.sleep(2.0)  # and the state shows all of it

    def run(self, seconds, rate):
        before = self.inputs
        start = time.perf_counter()
        count = int(seconds * rate)
        answers = []
        asked = None
        for number in range(count):
            if number % 50 == 0:
                if asked is not None:
                    answers.append(self.arrival - asked if self.arrival > asked else None)
                is_near = number % 100 == 0
                asked = time.perf_counter() if is_near else None
                distance = 0.5 if is_near else 5.0
                self.readings.publish(Reading(valid=True, distance=distance))
            else:
                self.charges.publish(Int16(data=number % 101))
            time.sleep(max(0.0, start + (number + 1) / rate - time.perf_counter()))
        spent = time.perf_counter() - start
        for _ in range(300):
            if self.inputs - before >= count:
                break
            time.sleep(0.1)
        received = self.inputs - before
        return {"sent": count, "received": received, "seconds": spent, "answers": answers}


def main():
    rclpy.init()
    node = rclpy.create_node("flood")
    flood = Flood(node)
    with spinning(node):
        flood.await_controller()
        write(flood.run(float(sys.argv[1]), float(sys.argv[2])), sys.argv[3])


main()
