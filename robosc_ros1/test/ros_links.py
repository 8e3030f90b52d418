"""Which connections of a ROS 1 graph stand, as both their ends count them.

What is published over one that does not stand is lost, and to be a subscriber's is not enough: a rospy
publisher greets a subscriber before it adds it to those it sends to, and a subscriber that is told
twice of a publisher may connect twice, and drops the first connection. So a connection stands once
both ends count the same pair of sockets.

Tests and the nodes that they start both wait by these functions; nothing of rospy is needed.
"""

from __future__ import annotations

import re
import time
from collections.abc import Collection
from http.client import HTTPConnection
from typing import Any, NamedTuple
from xmlrpc.client import ServerProxy, Transport

__all__ = ["Link", "await_links", "missing_links"]

PATIENCE = 60.0
ANSWER_TIMEOUT = 10.0
"""Seconds for one answer of a node; who takes longer is asked again."""

_PORTS = re.compile(r" on port (\d+) to \[.*:(\d+) on socket")


class Link(NamedTuple):
    topic: str
    publisher: str
    subscriber: str


class _Patient(Transport):
    def make_connection(self, host: Any) -> HTTPConnection:
        connection = super().make_connection(host)
        connection.timeout = ANSWER_TIMEOUT
        return connection


def _ask(uri: str, question: str, *arguments: str) -> Any:
    """What the master or a node answers; None if that it does not know."""
    with ServerProxy(uri, transport=_Patient()) as node:
        code, _, answer = getattr(node, question)("/ros_links", *arguments)
    return answer if code == 1 else None


def _connections(master: str, node: str) -> list[Any] | None:
    """All connections that a node counts; None if it does not run, though it be registered."""
    uri = _ask(master, "lookupNode", node)
    if uri is None:
        return None
    try:
        return list(_ask(uri, "getBusInfo"))
    except TimeoutError:
        return []
    except OSError:
        return None


def _ports(connections: list[Any], topic: str, way: str) -> set[tuple[str, str]]:
    """The ports of a node's connections of a topic: (publisher's, subscriber's)."""
    found = set()
    for connection in connections:
        ports = _PORTS.search(connection[6])
        if (connection[4], connection[2]) == (topic, way) and ports is not None:
            found.add((ports[1], ports[2]) if way == "o" else (ports[2], ports[1]))
    return found


def missing_links(master: str, node: str, topics: Collection[str] | None = None) -> set[Link]:
    """The links of a node with those that run, on all or some topics, which do not stand yet."""
    publishers, subscribers, _ = map(dict, _ask(master, "getSystemState"))
    chosen = set(publishers).intersection(subscribers, topics or publishers) - {"/rosout"}
    links = {
        Link(topic, publisher, subscriber)
        for topic in chosen
        for publisher in publishers[topic]
        for subscriber in subscribers[topic]
        if node in (publisher, subscriber)
    }
    # Publishers first: what they count, and a subscriber still has later, is no connection dropped.
    sends = {name: _connections(master, name) for name in {link.publisher for link in links}}
    receives = {name: _connections(master, name) for name in {link.subscriber for link in links}}

    def is_missing(link: Link) -> bool:
        sending, receiving = sends[link.publisher], receives[link.subscriber]
        if sending is None or receiving is None:
            return False
        sending = [c for c in sending if c[1] == link.subscriber]
        return not _ports(sending, link.topic, "o") & _ports(receiving, link.topic, "i")

    return {link for link in links if is_missing(link)}


def await_links(master: str, node: str, topics: Collection[str] | None = None) -> None:
    """Wait until all links of a node stand (see :func:`missing_links`).

    Raises:
        AssertionError: some never do.
    """
    end = time.monotonic() + PATIENCE
    while missing := missing_links(master, node, topics):
        assert time.monotonic() < end, f"waited {PATIENCE:g} s in vain for {sorted(missing)}"
        time.sleep(0.01)
