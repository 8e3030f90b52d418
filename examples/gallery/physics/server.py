"""An action server as a process of its own, which can be killed as any other node can.

It knows nothing of the world: goals and cancels go to the bridge through a pipe, and what becomes
of them comes back.

    python3 -m physics.server ROS NAME TYPE DESCRIPTOR
"""

from __future__ import annotations

import importlib
import os
import sys
import threading
from multiprocessing.connection import Connection
from typing import Any

__all__ = ["Link", "node_name"]


class Link:
    """The server's end of the pipe to the bridge. Any thread may tell."""

    def __init__(self, descriptor: int) -> None:
        self._pipe = Connection(descriptor)
        self._lock = threading.Lock()

    def tell(self, *news: Any) -> None:
        """Tell ``("ready",)``, ``("goal", identifier, request)`` or ``("cancel", identifier)``."""
        with self._lock:
            self._pipe.send(news)

    def has_order(self, seconds: float) -> bool:
        return self._pipe.poll(seconds)

    def order(self) -> tuple[str, tuple[Any, ...]]:
        """Return the next order, a method of the server and its arguments. Ends with the bridge."""
        try:
            name, *arguments = self._pipe.recv()
        except (EOFError, OSError):
            os._exit(0)
        return name, tuple(arguments)


def node_name(action: str) -> str:
    return action.strip("/").replace("/", "_") + "_server"


def main() -> None:
    version, name, type_, descriptor = sys.argv[1:]
    module = importlib.import_module(f"physics.ros{version}_server")
    link = Link(int(descriptor))
    link.order()  # to begin: what takes long was done before
    module.serve(name, type_, link)


if __name__ == "__main__":
    main()
