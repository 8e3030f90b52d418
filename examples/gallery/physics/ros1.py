"""The bridge's end of ROS 1: topics, /clock and action servers by name, nothing of any world."""

from __future__ import annotations

import threading
import time
from collections.abc import Callable
from queue import Empty, SimpleQueue
from typing import Any

import actionlib
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

    def serve(self, name: str, type_: str, accept: Callable[[Goal], None]) -> Server:
        """Begin to serve an action; ``accept`` gets each goal."""
        return Server(name, type_, lambda goal: self._inbox.put(lambda: accept(goal)))

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


class Server:
    """An action server that may be killed: it goes away like a process, without a word."""

    def __init__(self, name: str, type_: str, accept: Callable[[Goal], None]) -> None:
        self._goals: dict[str, Goal] = {}
        self._accept = accept
        self._lock = threading.Lock()
        self._server = actionlib.ActionServer(
            name, get_message_class(f"{type_}Action"), self._on_goal, self._on_cancel, False
        )
        self._server.start()

    def _on_goal(self, handle: Any) -> None:
        handle.set_accepted()
        goal = Goal(handle)
        with self._lock:
            self._goals[handle.get_goal_id().id] = goal
        self._accept(goal)

    def _on_cancel(self, handle: Any) -> None:
        with self._lock:
            goal = self._goals.get(handle.get_goal_id().id)
        if goal is not None:
            goal.is_cancelled = True

    def kill(self) -> None:
        self._server.stop()


class Goal:
    """One goal of an action server, until it is ended."""

    def __init__(self, handle: Any) -> None:
        self._handle = handle
        self.is_cancelled = False
        self.request = handle.get_goal()

    def feed_back(self, fields: dict[str, Any]) -> None:
        feedback = type(self._handle.action_server.ActionFeedback().feedback)
        self._handle.publish_feedback(fill(feedback(), fields))

    def end(self, how: str, fields: dict[str, Any] | None = None) -> None:
        """End it: ``succeeded``, ``aborted`` or ``canceled``, with the fields of the result."""
        result = self._handle.action_server.ActionResultType()
        getattr(self._handle, f"set_{how}")(fill(result, fields or {}))
