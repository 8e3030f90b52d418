"""The bridge's end of ROS 1: topics and /clock, nothing of any world."""

from __future__ import annotations

import time
from collections.abc import Callable
from queue import Empty, SimpleQueue
from typing import Any

import rospy
from rosgraph_msgs.msg import Clock
from roslib.message import get_message_class

from physics.messages import fill

__all__ = ["Middleware"]


class Middleware:
    """Callbacks are called in ``exchange`` alone, so the bridge needs no locks."""

    def __init__(self, name: str) -> None:
        rospy.init_node(name, disable_signals=True)
        self._inbox: SimpleQueue[Callable[[], None]] = SimpleQueue()
        self._publishers: dict[str, Any] = {}
        self._subscribers: list[Any] = []
        self._clock = rospy.Publisher("/clock", Clock, queue_size=10, tcp_nodelay=True)

    def publish(self, topic: str, type_: str, fields: dict[str, Any], now: float) -> None:
        publisher = self.advertise(topic, type_)
        message = fill(publisher.data_class(), fields)
        if hasattr(message, "header"):
            message.header.stamp = rospy.Time.from_sec(now)
        publisher.publish(message)

    def advertise(self, topic: str, type_: str) -> Any:
        if topic not in self._publishers:
            self._publishers[topic] = rospy.Publisher(
                topic, get_message_class(type_), queue_size=100, tcp_nodelay=True
            )
        return self._publishers[topic]

    def subscribe(self, topic: str, type_: str, callback: Callable[[Any], None]) -> None:
        def queue(message: Any) -> None:
            self._inbox.put(lambda: callback(message))

        self._subscribers.append(
            rospy.Subscriber(topic, get_message_class(type_), queue, tcp_nodelay=True)
        )

    def post(self, function: Callable[[], None]) -> None:
        """Have the function called in ``exchange``. Any thread may."""
        self._inbox.put(function)

    def connected(self) -> bool:
        """Whether somebody is at the other end of every topic."""
        ends = [*self._publishers.values(), *self._subscribers, self._clock]
        return all(end.get_num_connections() > 0 for end in ends)

    def clock(self, now: float) -> None:
        self._clock.publish(Clock(rospy.Time.from_sec(now)))

    def exchange(self, until: Callable[[], bool], seconds: float) -> None:
        """Handle what arrives until the condition holds, but for so many seconds at most."""
        end = time.monotonic() + seconds
        while True:
            while not self._inbox.empty():
                self._inbox.get()()
            left = end - time.monotonic()
            if until() or left <= 0.0:
                return
            try:
                self._inbox.get(timeout=left)()
            except Empty:
                return

    def close(self) -> None:
        rospy.signal_shutdown("the run has ended")
