"""What the engine needs of the middleware. ``node.py`` implements it; tests and simulators do too.

The engine calls a port from its one thread; no method may block. Whatever comes back goes through
``Engine.post`` and ``Engine.report``, which may be called from any thread.
"""

from __future__ import annotations

from typing import Any, Dict, Optional

__all__ = ["Data", "Port"]

Data = Optional[Dict[str, Any]]
"""Fields to set, nested; all others keep the defaults of their message. None: all do."""


class Port:
    def now(self) -> float:
        """Seconds on the clock of the pace: a steady one, or ROS time when that is simulated."""
        raise NotImplementedError

    def send(self, key: str, data: Data) -> None:
        """Publish an incoming message. An exception means that it was not sent."""
        raise NotImplementedError

    def call(self, key: str, data: Data, token: int, timeout: float) -> None:
        """Start a service call; report "response" with the message, or "error" with the reason."""
        raise NotImplementedError

    def start(self, key: str, data: Data, token: int, timeout: float) -> None:
        """Send a goal; report "accepted", "feedback", then "response" or "error"."""
        raise NotImplementedError

    def cancel(self, key: str, token: int) -> None:
        """Ask the server to cancel the goal, also if it is still to be sent."""
        raise NotImplementedError

    def abandon(self, key: str, token: int) -> None:
        """The engine takes no more interest in this call; let go of what it holds."""

    def silence(self, key: str) -> Optional[float]:
        """Seconds of wall time since the action's server was last heard of; None: not watched."""
        return None

    def log(self, level: str, text: str) -> None:
        """Write to the log; level is "debug", "info", "warning" or "error"."""
        raise NotImplementedError

    def exit(self, code: int) -> None:
        """End the process soon. The engine is not to be waited for: it is the one who asks."""
