"""Ports and ROS domains that nobody uses, nor any other test or demo on this machine is about to."""

from __future__ import annotations

import contextlib
import random
import socket
from collections import deque
from collections.abc import Iterator

__all__ = ["free_domain", "free_port"]


def taken(name: str) -> socket.socket | None:
    """Take a name among all tests on this machine, of whatever checkout; None if it is in use.

    It is free again when the socket is closed, or the process has ended.
    """
    lock = socket.socket(socket.AF_UNIX)
    try:
        lock.bind(f"\0robosc-{name}")
    except OSError:
        lock.close()
        return None
    return lock


_PORTS: deque[socket.socket] = deque(maxlen=200)
"""Holds the names of the last ports that this process took, in use or about to be."""


def free_port() -> int:
    """A port that nobody listens on, nor gets from the system or for a test before it is used.

    Nodes take theirs from the range of the system's own (from 32768 on), also while a master that
    shall have this one is only starting.
    """
    while True:
        port = random.SystemRandom().randrange(20000, 32768)
        if (lock := taken(f"port-{port}")) is None:
            continue
        with socket.socket() as probe, contextlib.suppress(OSError):
            probe.bind(("localhost", port))
            _PORTS.append(lock)
            return port


@contextlib.contextmanager
def free_domain() -> Iterator[int]:
    """A ROS_DOMAIN_ID that no other test on this machine uses now, of whatever checkout.

    People take low ones.
    """
    for domain in range(100, 0, -1):
        if (lock := taken(f"domain-{domain}")) is not None:
            with lock:
                yield domain
            return
    raise AssertionError("all ROS domains are in use")
