"""Sends to the relay and to the controller in turn, and writes how long the answers took (JSON).

Arguments: samples of each, seconds and rate of the flood that follows (0: none), the file.
"""

import json
import sys
import threading
import time
from pathlib import Path

import rospy
from diagnostic_msgs.msg import DiagnosticArray
from std_msgs.msg import Empty, Int16, String


class Echo:
    """A pair of topics: sends, and waits for the answer."""

    def __init__(self, topic):
        # A queue without limit, so that nothing can be lost here.
        self.publisher = rospy.Publisher(topic, Int16, queue_size=0, tcp_nodelay=True)
        self.answered = threading.Event()
        self.arrival = 0.0

    def hear(self, _):
        self.arrival = time.perf_counter()
        self.answered.set()

    def measure(self, value):
        """Seconds from sending to the answer; None if it does not come."""
        self.answered.clear()
        start = time.perf_counter()
        self.publisher.publish(value)
        return self.arrival - start if self.answered.wait(2.0) else None


def await_connections(*publishers):
    while not all(p.get_num_connections() for p in publishers):
        time.sleep(0.01)


def latencies(samples):
    relay, controller = Echo("/relay_in"), Echo("/level")
    rospy.Subscriber("/relay_out", Int16, relay.hear, tcp_nodelay=True)
    rospy.Subscriber("/blow", Int16, controller.hear, tcp_nodelay=True)
    rospy.Subscriber("/halt", Empty, controller.hear, tcp_nodelay=True)
    await_connections(relay.publisher, controller.publisher)
    time.sleep(1.0)
    taken = {"relay": [], "controller": []}
    for number in range(samples):
        for name, echo in (("relay", relay), ("controller", controller)):
            # The level changes sides each time, so that each message enables another command.
            taken[name].append(echo.measure(3 if number % 2 else 9))
            time.sleep(0.002)
    return taken, controller


def flood(controller, seconds, rate):
    """Send at a rate, and measure the controller's answers meanwhile."""
    states = []
    name = "/probe_controller/state"
    rospy.Subscriber(name, String, lambda m: states.append((time.perf_counter(), m.data)))
    backlogs = []

    def diagnosed(message):
        values = {entry.key: entry.value for entry in message.status[0].values}
        backlogs.append(int(values["backlog"]))

    rospy.Subscriber("/diagnostics", DiagnosticArray, diagnosed)
    time.sleep(2.0)  # until the state is that after the last sample
    before = json.loads(states[-1][1])["counters"]["inputs"]
    publisher = controller.publisher
    start = time.perf_counter()
    count = int(seconds * rate)
    answers = []
    for number in range(count):
        # The level changes sides every hundredth message, and that answer is measured.
        value = 3 if number // 100 % 2 else 9
        if number % 100 == 0:
            controller.answered.clear()
            asked = time.perf_counter()
        publisher.publish(value)
        if number % 100 == 99:
            answers.append(controller.arrival - asked if controller.arrival > asked else None)
        time.sleep(max(0.0, start + (number + 1) / rate - time.perf_counter()))
    spent = time.perf_counter() - start
    inputs = 0
    for _ in range(300):
        inputs = json.loads(states[-1][1])["counters"]["inputs"] - before
        if inputs >= count:
            break
        time.sleep(0.1)
    return {
        "sent": count,
        "received": inputs,
        "seconds": spent,
        "answers": answers,
        "backlogs": backlogs,
    }


def main():
    rospy.init_node("latency")
    samples, seconds, rate = int(sys.argv[1]), float(sys.argv[2]), float(sys.argv[3])
    taken, controller = latencies(samples)
    result = {"latencies": taken}
    if seconds:
        result["flood"] = flood(controller, seconds, rate)
    with Path(sys.argv[4]).open("w", encoding="utf-8") as file:
        json.dump(result, file)
    rospy.signal_shutdown("done")


main()
