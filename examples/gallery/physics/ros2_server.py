"""An action server's end of ROS 2: what ``ros1_server`` is for ROS 1."""

from __future__ import annotations

import threading
from functools import partial
from typing import Any

import rclpy
from rclpy.action import ActionServer, CancelResponse
from rclpy.executors import SingleThreadedExecutor

from physics.messages import fill, interface
from physics.ros2 import Inbox
from physics.server import Link, node_name

__all__ = ["serve"]

LOOK = 0.1
"""Seconds of real time between two looks for a client."""


def serve(name: str, type_: str, link: Link) -> None:
    """Serve an action for ever."""
    rclpy.init()
    executor = SingleThreadedExecutor()
    server = Server(name, type_, link)
    executor.add_node(server.node)
    inbox = Inbox(executor)

    def take_orders() -> None:
        while True:
            order, arguments = link.order()
            inbox.put(partial(getattr(server, order), *arguments))

    threading.Thread(target=take_orders, daemon=True).start()
    while not server.is_connected():
        executor.spin_once(timeout_sec=LOOK)
    link.tell("ready")
    executor.spin()


class Server:
    """One action; the goals are known by their identifiers."""

    def __init__(self, name: str, type_: str, link: Link) -> None:
        self.node = rclpy.create_node(node_name(name))
        self._link, self._name = link, name
        self._goals: dict[str, Any] = {}
        self._type = interface(type_, "action")
        self._server = ActionServer(
            self.node,
            self._type,
            name,
            self._execute,
            handle_accepted_callback=self._on_goal,
            cancel_callback=self._on_cancel,
        )

    def _execute(self, handle: Any) -> Any:
        raise AssertionError("goals are ended by Server.end")

    def _on_goal(self, handle: Any) -> None:
        identifier = bytes(handle.goal_id.uuid).hex()
        self._goals[identifier] = handle
        self._link.tell("goal", identifier, handle.request)

    def _on_cancel(self, handle: Any) -> Any:
        self._link.tell("cancel", bytes(handle.goal_id.uuid).hex())
        return CancelResponse.ACCEPT

    def is_connected(self) -> bool:
        """Whether a client is at the other end of every topic and service."""
        ends = f"{self._name}/_action/"
        topics = all(self.node.count_subscribers(ends + t) > 0 for t in ("feedback", "status"))
        services = "send_goal", "cancel_goal", "get_result"
        return topics and all(self.node.count_clients(ends + s) > 0 for s in services)

    def feed_back(self, identifier: str, fields: dict[str, Any]) -> None:
        self._goals[identifier].publish_feedback(fill(self._type.Feedback(), fields))

    def end(self, identifier: str, how: str, fields: dict[str, Any]) -> None:
        """End a goal: ``succeeded``, ``aborted`` or ``canceled``, with the fields of the result."""

        def finish(handle: Any) -> Any:
            {"succeeded": handle.succeed, "aborted": handle.abort, "canceled": handle.canceled}[
                how
            ]()
            return fill(self._type.Result(), fields)

        self._goals.pop(identifier).execute(finish)
