"""ROS 2: the parts that the weight of messages is measured with; see weight_node.py."""

import random
import sys
import threading
import time

import rclpy
from measuring_ros2 import spinning, write
from rclpy.serialization import serialize_message
from std_msgs.msg import Bool, Float32MultiArray, Float64

LONGEST = 8.0


def bare(node):
    out = node.create_publisher(Bool, "/echo", 10)
    node.create_subscription(Float32MultiArray, "/cloud", lambda _: None, 1)
    node.create_subscription(Bool, "/estop", out.publish, 1)
    rclpy.spin(node)


def heavy(node, megabytes, rate):
    data = serialize_message(Float32MultiArray(data=[2.0] * int(megabytes * 250000)))
    publisher = node.create_publisher(Float32MultiArray, "/cloud", 1)
    while rclpy.ok():
        publisher.publish(data)
        time.sleep(1 / rate)


def probe(node, samples, file):
    estop = node.create_publisher(Bool, "/estop", 10)
    arrived = {"bare": threading.Event(), "node": threading.Event()}
    times = dict.fromkeys(arrived, 0.0)
    wanted = [False]

    def hear(name, pressed):
        if pressed == wanted[0] and not arrived[name].is_set():
            times[name] = time.perf_counter()
            arrived[name].set()

    node.create_subscription(Bool, "/echo", lambda m: hear("bare", m.data), 10)
    node.create_subscription(Float64, "/vel", lambda m: hear("node", m.data == 0.0), 10)
    chance = random.Random(1)
    taken = {name: [] for name in arrived}
    with spinning(node):
        while estop.get_subscription_count() < 2:
            time.sleep(0.05)
        time.sleep(3.0)
        for number in range(samples):
            for event in arrived.values():
                event.clear()
            wanted[0] = number % 2 == 0
            start = time.perf_counter()
            estop.publish(Bool(data=wanted[0]))
            for name, event in arrived.items():
                came = event.wait(max(0.0, start + LONGEST - time.perf_counter()))
                taken[name].append(times[name] - start if came else None)
            time.sleep(chance.uniform(0.02, 0.2))
        write(taken, file)


rclpy.init()
own = rclpy.create_node("weight_" + sys.argv[1])
if sys.argv[1] == "bare":
    bare(own)
elif sys.argv[1] == "heavy":
    heavy(own, float(sys.argv[2]), float(sys.argv[3]))
else:
    probe(own, int(sys.argv[2]), sys.argv[3])
