"""An action server's end of ROS 1."""

from __future__ import annotations

import time
from typing import Any

import actionlib
import rospy
from roslib.message import get_message_class

from physics.messages import fill
from physics.server import Link, node_name

__all__ = ["serve"]

BEAT = 0.1
"""Seconds of real time between two messages of status: it is by them that a server is alive, also
while simulated time stands."""


def serve(name: str, type_: str, link: Link) -> None:
    """Serve an action for ever."""
    rospy.init_node(node_name(name), disable_signals=True)
    server = Server(name, type_, link)
    ready, next_beat = False, 0.0
    while True:
        if link.has_order(BEAT):
            order, arguments = link.order()
            getattr(server, order)(*arguments)
        if time.monotonic() >= next_beat:
            server.beat()
            next_beat = time.monotonic() + BEAT
        if not ready and server.is_connected():
            ready = True
            link.tell("ready")


class Server:
    """One action; the goals are known by their identifiers."""

    def __init__(self, name: str, type_: str, link: Link) -> None:
        self._link = link
        self._goals: dict[str, Any] = {}
        self._server = actionlib.ActionServer(
            name, get_message_class(f"{type_}Action"), self._on_goal, self._on_cancel, False
        )
        self._server.start()

    def _on_goal(self, handle: Any) -> None:
        identifier = handle.get_goal_id().id
        self._goals[identifier] = handle
        handle.set_accepted()
        self._link.tell("goal", identifier, handle.get_goal())

    def _on_cancel(self, handle: Any) -> None:
        self._link.tell("cancel", handle.get_goal_id().id)

    def is_connected(self) -> bool:
        """Whether a client is at the other end of every topic."""
        server = self._server
        ends = server.goal_sub, server.cancel_sub, server.status_pub
        ends += server.result_pub, server.feedback_pub
        return all(end.get_num_connections() > 0 for end in ends)

    def beat(self) -> None:
        with self._server.lock:
            self._server.publish_status()

    def feed_back(self, identifier: str, fields: dict[str, Any]) -> None:
        message = type(self._server.ActionFeedback().feedback)()
        self._goals[identifier].publish_feedback(fill(message, fields))

    def end(self, identifier: str, how: str, fields: dict[str, Any]) -> None:
        """End a goal: ``succeeded``, ``aborted`` or ``canceled``, with the fields of the result."""
        handle = self._goals.pop(identifier)
        getattr(handle, f"set_{how}")(fill(self._server.ActionResultType(), fields))
