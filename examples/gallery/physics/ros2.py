"""The bridge's end of ROS 2: what ``ros1`` is for ROS 1."""

from __future__ import annotations

import time
from collections.abc import Callable
from queue import SimpleQueue
from typing import Any

import rclpy
from rclpy.executors import SingleThreadedExecutor
from rclpy.qos import DurabilityPolicy, QoSProfile
from rosgraph_msgs.msg import Clock

from physics.messages import fill, interface

__all__ = ["Inbox", "Middleware"]


class Inbox:
    """Functions that an executor calls in the order of their coming; rclpy: newest first."""

    def __init__(self, executor: SingleThreadedExecutor) -> None:
        self._executor = executor
        self._functions: SimpleQueue[Callable[[], None]] = SimpleQueue()

    def put(self, function: Callable[[], None]) -> None:
        """Have a function called. Any thread may."""
        self._functions.put(function)
        self._executor.create_task(lambda: self._functions.get_nowait()())


class Middleware:
    """Callbacks are called in ``exchange`` alone, so the bridge needs no locks."""

    def __init__(self, name: str) -> None:
        rclpy.init()
        self._node = rclpy.create_node(name)
        self._executor = SingleThreadedExecutor()
        self._executor.add_node(self._node)
        self._inbox = Inbox(self._executor)
        self._publishers: dict[str, Any] = {}
        self._subscribers: list[Any] = []
        self._clock = self._node.create_publisher(Clock, "/clock", 10)

    def publish(self, topic: str, type_: str, fields: dict[str, Any], now: float) -> None:
        publisher = self.advertise(topic, type_)
        message = fill(publisher.msg_type(), fields)
        if hasattr(message, "header"):
            message.header.stamp = stamp(now)
        publisher.publish(message)

    def advertise(self, topic: str, type_: str) -> Any:
        if topic not in self._publishers:
            self._publishers[topic] = self._node.create_publisher(
                interface(type_, "msg"), topic, 100
            )
        return self._publishers[topic]

    def subscribe(self, topic: str, type_: str, callback: Callable[[Any], None]) -> None:
        # What the controller says of itself is latched, and then heard by who comes later.
        kept = topic.endswith(("/state", "/model", "/ready"))
        durability = DurabilityPolicy.TRANSIENT_LOCAL if kept else DurabilityPolicy.VOLATILE
        self._subscribers.append(
            self._node.create_subscription(
                interface(type_, "msg"),
                topic,
                callback,
                QoSProfile(depth=100, durability=durability),
            )
        )

    def post(self, function: Callable[[], None]) -> None:
        """Have the function called in ``exchange``. Any thread may."""
        self._inbox.put(function)

    def connected(self) -> bool:
        """Whether somebody is at the other end of every topic."""
        publishers = [*self._publishers.values(), self._clock]
        return all(p.get_subscription_count() > 0 for p in publishers) and all(
            self._node.count_publishers(s.topic_name) > 0 for s in self._subscribers
        )

    def clock(self, now: float) -> None:
        self._clock.publish(Clock(clock=stamp(now)))

    def exchange(self, until: Callable[[], bool], seconds: float) -> None:
        """Handle what arrives until the condition holds, but for so many seconds at most."""
        end = time.monotonic() + seconds
        while not until() and (left := end - time.monotonic()) > 0.0:
            self._executor.spin_once(timeout_sec=left)

    def close(self) -> None:
        self._executor.shutdown()
        rclpy.shutdown()


def stamp(now: float) -> Any:
    """Return a time of the simulation as a message."""
    from builtin_interfaces.msg import Time

    seconds, nanoseconds = divmod(round(now * 1e9), 10**9)
    return Time(sec=seconds, nanosec=nanoseconds)
