"""Connections that send at once what a subscriber takes at once, on real sockets without a master."""

from __future__ import annotations

import random
import socket
import struct
import sys
import threading
from collections.abc import Iterator
from importlib import import_module
from pathlib import Path
from typing import Any

import pytest

TEMPLATES = Path(__file__).resolve().parents[2] / "templates" / "ros1"
QUEUE = 10
HEAD = struct.Struct("<II")  # the size of what follows, the number of the message


def transport_to(ours: socket.socket) -> Any:
    """A connection of rospy's."""
    base: Any = import_module("rospy.impl.tcpros_base")
    protocol = base.TCPROSTransportProtocol("/topic", None)
    protocol.direction = "o"
    transport = base.TCPROSTransport(protocol, "/topic")
    transport.set_socket(ours, "subscriber")
    return transport


class Link:
    """A connection of rospy's under a prompt one, and the socket of its subscriber."""

    def __init__(self, queue: int = QUEUE) -> None:
        module: Any = import_module("ros_connections")
        ours, self.subscriber = socket.socketpair()
        ours.setsockopt(socket.SOL_SOCKET, socket.SO_SNDBUF, 4096)
        self.subscriber.settimeout(60)
        self.transport = transport_to(ours)
        self.connection = module.PromptConnection(self.transport, queue)

    def publish(self, number: int, size: int = 0) -> None:
        self.connection.write_data(HEAD.pack(size, number) + bytes([number % 256]) * size)

    def receive(self, size: int, flags: int = 0) -> bytes:
        found = b""
        while len(found) < size:
            part = self.subscriber.recv(size - len(found), flags)
            assert part, "the connection was closed"
            found += part
        return found

    def take(self, flags: int = 0) -> int:
        """The number of the next message, which has come whole."""
        size, number = HEAD.unpack(self.receive(HEAD.size, flags))
        assert self.receive(size, flags) == bytes([number % 256]) * size
        return int(number)

    def close(self) -> None:
        self.transport.close()
        self.subscriber.close()


@pytest.fixture
def link(ros: None, monkeypatch: pytest.MonkeyPatch) -> Iterator[Link]:
    monkeypatch.setattr(sys, "path", [str(TEMPLATES), *sys.path])
    link = Link()
    yield link
    link.close()
    link.connection._thread.join(60)
    assert not link.connection._thread.is_alive()


def test_a_message_is_there_when_it_was_published(link: Link) -> None:
    for number in range(100):
        link.publish(number, size=100)
        assert link.take(socket.MSG_DONTWAIT) == number
    assert link.transport.stat_num_msg == 100
    assert link.transport.stat_bytes == 100 * (HEAD.size + 100)


@pytest.mark.parametrize("is_fast", [False, True])
def test_publishers_use_them(link: Link, monkeypatch: pytest.MonkeyPatch, is_fast: bool) -> None:
    """Also for a subscriber that connects before rospy has told the publisher its queue's length."""
    module: Any = import_module("ros_connections")
    topics: Any = import_module("rospy.topics")
    monkeypatch.setattr(topics, "QueuedConnection", topics.QueuedConnection)
    for method in ("add_connection", "set_queue_size"):
        monkeypatch.setattr(topics._PublisherImpl, method, getattr(topics._PublisherImpl, method))
    module.send_promptly()
    publisher = topics._PublisherImpl("/topic", import_module("std_msgs.msg").Int16)
    ours, _ = socket.socketpair()
    steps = [
        lambda: publisher.set_queue_size(QUEUE),
        lambda: publisher.add_connection(transport_to(ours)),
    ]
    for step in reversed(steps) if is_fast else steps:
        step()
    (connection,) = publisher.connections
    connection.close()
    assert isinstance(connection, module.PromptConnection)


def test_who_publishes_never_waits_and_the_oldest_messages_are_dropped(link: Link) -> None:
    """As with rospy's own: a subscriber that stands still gets what the socket took, and the last."""
    for number in range(1000):
        link.publish(number, size=1000)
    taken = [link.take()]
    while taken[-1] < 999:
        taken.append(link.take())
    assert taken == sorted(set(taken))
    assert taken[:2] == [0, 1]
    assert taken[-QUEUE:] == list(range(1000 - QUEUE, 1000))
    assert len(taken) < 1000


@pytest.mark.parametrize("seed", range(3))
def test_a_slow_subscriber_gets_whole_messages_in_order(link: Link, seed: int) -> None:
    chance = random.Random(seed)
    taken: list[int] = []

    def listen() -> None:
        while taken[-1:] != [-1 % 2**32]:
            taken.append(link.take())

    listening = threading.Thread(target=listen)
    listening.start()
    for number in range(2000):
        link.publish(number, size=chance.choice([0, 10, 3000, 9000]))
    link.publish(-1 % 2**32)
    listening.join(60)
    assert not listening.is_alive()
    assert taken == sorted(set(taken))
    assert taken[-2] == 1999


def test_a_subscriber_that_has_gone_ends_the_connection(link: Link) -> None:
    closed = threading.Event()
    link.transport.set_cleanup_callback(lambda _: closed.set())
    link.publish(1)
    link.subscriber.close()
    link.publish(2)
    assert closed.wait(60)
    assert link.transport.done


class Publisher:
    """As rospy has it, with one connection."""

    def __init__(self, link: Link) -> None:
        self.impl = self
        self.connections = [link.connection]


def test_a_command_that_is_not_taken_at_once_is_not_sent(
    ros: None, monkeypatch: pytest.MonkeyPatch
) -> None:
    """A subscriber that takes its time must not get a movement that has been forbidden since."""
    monkeypatch.setattr(sys, "path", [str(TEMPLATES), *sys.path])
    module: Any = import_module("ros_connections")
    link = Link(queue=module.AT_ONCE)
    publisher = Publisher(link)
    try:
        sent, number = [], 0
        while link.connection.took:
            link.publish(number, size=1000)
            sent.append(number)
            number += 1
        assert len(sent) > 2
        link.publish(number, size=1000)  # nor is this one
        assert not module.is_taken(publisher)
        taken = [link.take() for _ in sent[:-1]]
        assert taken == sent[:-1]
        while not link.connection.took:
            link.publish(1000, size=10)
        assert module.is_taken(publisher)
        assert link.take() == 1000
    finally:
        link.close()
