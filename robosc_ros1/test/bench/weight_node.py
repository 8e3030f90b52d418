"""ROS 1: the parts that the weight of messages is measured with.

Arguments: "bare" (a subscriber that does nothing with what is heavy, and passes on what is light);
"heavy", megabytes, rate in Hz; or "probe", samples, the file, which measures how long a light
message takes through the bare node and through a generated one (JSON).
"""

import json
import random
import sys
import threading
import time
from pathlib import Path

import rospy
from rospy.msg import AnyMsg
from std_msgs.msg import Bool, Float32MultiArray, Float64

LONGEST = 8.0


def bare():
    out = rospy.Publisher("/echo", Bool, queue_size=10, tcp_nodelay=True)
    rospy.Subscriber("/cloud", Float32MultiArray, lambda _: None, queue_size=1)
    rospy.Subscriber("/estop", Bool, out.publish, queue_size=1, tcp_nodelay=True)
    rospy.spin()


def heavy(megabytes, rate):
    from io import BytesIO

    buffer = BytesIO()
    Float32MultiArray(data=[2.0] * int(megabytes * 250000)).serialize(buffer)
    message = AnyMsg()
    message._buff = buffer.getvalue()

    class Packed(AnyMsg):
        _type, _md5sum = Float32MultiArray._type, Float32MultiArray._md5sum
        _full_text = Float32MultiArray._full_text

    publisher = rospy.Publisher("/cloud", Packed, queue_size=1)
    packed = Packed()
    packed._buff = message._buff
    while not rospy.is_shutdown():
        publisher.publish(packed)
        time.sleep(1 / rate)


def probe(samples, file):
    estop = rospy.Publisher("/estop", Bool, queue_size=10, tcp_nodelay=True)
    arrived = {"bare": threading.Event(), "node": threading.Event()}
    times = dict.fromkeys(arrived, 0.0)
    wanted = [False]

    def hear(name, pressed):
        if pressed == wanted[0] and not arrived[name].is_set():
            times[name] = time.perf_counter()
            arrived[name].set()

    rospy.Subscriber("/echo", Bool, lambda m: hear("bare", m.data), tcp_nodelay=True)
    rospy.Subscriber("/vel", Float64, lambda m: hear("node", m.data == 0.0), tcp_nodelay=True)
    while estop.get_num_connections() < 2:
        time.sleep(0.05)
    time.sleep(3.0)
    taken = {name: [] for name in arrived}
    chance = random.Random(1)
    for number in range(samples):
        for event in arrived.values():
            event.clear()
        wanted[0] = number % 2 == 0
        start = time.perf_counter()
        estop.publish(wanted[0])
        for name, event in arrived.items():
            came = event.wait(max(0.0, start + LONGEST - time.perf_counter()))
            taken[name].append(times[name] - start if came else None)
        time.sleep(chance.uniform(0.02, 0.2))
    Path(file).write_text(json.dumps(taken), encoding="utf-8")


rospy.init_node("weight_" + sys.argv[1])
if sys.argv[1] == "bare":
    bare()
elif sys.argv[1] == "heavy":
    heavy(float(sys.argv[2]), float(sys.argv[3]))
else:
    probe(int(sys.argv[2]), sys.argv[3])
