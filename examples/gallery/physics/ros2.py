"""The bridge's end of ROS 2: what ``ros1`` is for ROS 1."""

from __future__ import annotations

import importlib
import time
from collections.abc import Callable
from typing import Any

import rclpy
from rclpy.action import ActionServer, CancelResponse
from rclpy.executors import SingleThreadedExecutor
from rosgraph_msgs.msg import Clock

from physics.messages import fill

__all__ = ["Middleware"]


class Middleware:
    """Callbacks are called in ``exchange`` alone, so the bridge needs no locks."""

    def __init__(self, name: str) -> None:
        rclpy.init()
        self._node = rclpy.create_node(name)
        self._executor = SingleThreadedExecutor()
        self._executor.add_node(self._node)
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
        self._subscribers.append(
            self._node.create_subscription(interface(type_, "msg"), topic, callback, 100)
        )

    def serve(self, name: str, type_: str, accept: Callable[[Goal], None]) -> Server:
        """Begin to serve an action; ``accept`` gets each goal."""
        return Server(self._node, name, type_, accept)

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


class Server:
    """An action server that may be killed: it goes away like a process, without a word."""

    def __init__(self, node: Any, name: str, type_: str, accept: Callable[[Goal], None]) -> None:
        self._type = interface(type_, "action")
        self._server = ActionServer(
            node,
            self._type,
            name,
            self._end,
            handle_accepted_callback=lambda handle: accept(Goal(handle, self._type)),
            cancel_callback=lambda _: CancelResponse.ACCEPT,
        )

    def _end(self, handle: Any) -> Any:
        raise AssertionError("goals are ended by Goal.end")

    def kill(self) -> None:
        self._server.destroy()


class Goal:
    """One goal of an action server, until it is ended."""

    def __init__(self, handle: Any, type_: Any) -> None:
        self._handle = handle
        self._type = type_
        self.request = handle.request

    @property
    def is_cancelled(self) -> bool:
        cancelled: bool = self._handle.is_cancel_requested
        return cancelled

    def feed_back(self, fields: dict[str, Any]) -> None:
        self._handle.publish_feedback(fill(self._type.Feedback(), fields))

    def end(self, how: str, fields: dict[str, Any] | None = None) -> None:
        """End it: ``succeeded``, ``aborted`` or ``canceled``, with the fields of the result."""

        def finish(handle: Any) -> Any:
            {"succeeded": handle.succeed, "aborted": handle.abort, "canceled": handle.canceled}[
                how
            ]()
            return fill(self._type.Result(), fields or {})

        self._handle.execute(finish)


def interface(type_: str, kind: str) -> Any:
    """Return the class of ``package/Name``, a ``msg`` or an ``action``."""
    package, name = type_.split("/")
    return getattr(importlib.import_module(f"{package}.{kind}"), name)


def stamp(now: float) -> Any:
    """Return a time of the simulation as a message."""
    from builtin_interfaces.msg import Time

    seconds, nanoseconds = divmod(round(now * 1e9), 10**9)
    return Time(sec=seconds, nanosec=nanoseconds)
