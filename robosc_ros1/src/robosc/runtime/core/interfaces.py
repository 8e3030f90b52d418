# Read by who writes robosc, and by what checks types: no package needs it.
"""What an engine asks of the middleware, and its reporter of what publishes documents."""

from __future__ import annotations

from typing import Any, Callable, Dict, Mapping, Optional, Sequence, Tuple

Data = Optional[Dict[str, Any]]
"""The fields to set, nested; all others keep their defaults. None: no fields to set."""


class Port:
    """The middleware, for an engine: implemented by nodes, simulators and tests.

    The engine calls a port from one thread at a time; no method may block. Inputs are passed to
    ``Engine.poster`` and ``Engine.report``, which may be called from any thread. A message may be
    handled before the function from ``poster`` returns, so its caller must not hold a lock that the
    port takes.
    """

    def now(self) -> float:
        """Return the time in seconds: of a steady clock, or ROS time if that is simulated
        (:data:`~.port.BEFORE_TIME` before it has started)."""
        raise NotImplementedError

    def stamp_time(self) -> float:
        """Return the time in seconds as the stamps of messages have it: ROS time."""
        return self.now()

    def check(self, key: str, kind: str, data: Data) -> None:
        """Raise any exception if the data do not fit the type of a command, which is a "request",
        or an answer: "response" or "feedback"."""

    def is_heard(self, key: str) -> bool:
        """Return whether somebody receives an incoming message now."""
        return True

    def send(self, key: str, data: Data) -> None:
        """Publish an incoming message. Raises any exception if it was not sent."""
        raise NotImplementedError

    def ready(self, key: str) -> bool:
        """Return whether the server of a service or an action can take a request now, at once. It
        is asked again while a request waits, also after ``Engine.look``; a port that has to connect
        first begins to."""
        return True

    def call(self, key: str, data: Data, token: int) -> None:
        """Send a request to a service that is ready, at once; report "response" with the message,
        or "error" with the reason.

        Raises:
            NotTaken: it is not ready any more.
        """
        raise NotImplementedError

    def start(self, key: str, data: Data, token: int) -> None:
        """Send a goal in the same way; report "accepted", "feedback", then "response", "error" or
        "cancelled"."""
        raise NotImplementedError

    def cancel(self, key: str, token: int) -> None:
        """Ask the server to cancel a goal that was sent until it has ended, which is reported. Does
        nothing if it was asked before."""
        raise NotImplementedError

    def abandon(self, key: str, token: int) -> None:
        """Release the resources of a call or goal whose result is no longer needed; does nothing
        for one that was not sent."""

    def silence(self, key: str) -> float | None:
        """Return the wall time in seconds since the last status of the action server; None:
        unknown."""
        return None

    def absent(self, key: str) -> str | None:
        """Return why no server has taken a request whose deadline is over, as text; None:
        unknown."""
        return None

    def connects(self, key: str) -> bool:
        """Whether a connection to a server that may be there is being made, or has been made for a
        request that waits."""
        return False

    def works(self, key: str) -> bool:
        """Whether the server of a service may still answer the latest call."""
        return False

    def lost(self, key: str) -> bool:
        """Whether the server of a cancelled goal has been gone for so long that it must have ended
        (silence does not count)."""
        return False

    def faults(self) -> list[str]:
        """Return the current faults of servers, as texts."""
        return []

    def unheard(self) -> Mapping[str, str]:
        """Return the messages, by key, to none of whose publishers this node is connected, with the
        names of their topics."""
        return {}

    def log(self, level: str, text: str) -> None:
        """Write to the log; level is "debug", "info", "warning" or "error"."""
        raise NotImplementedError

    def await_inputs(self, done: Callable[[], None]) -> bool:
        """Have ``done`` called, in any thread, once the engine was given all messages that wait for
        it outside now; False if none can, since there is no outside: ``done`` is not called then.

        Threads of a middleware may have put what waited into the engine's queue already; what
        ``done`` queues comes behind it.
        """
        return False

    def exit(self, code: int) -> None:
        """End the process soon, without waiting for the engine, which calls this."""


class Outlet:
    """The destination of documents, implemented by the node; only the reporter's thread calls
    it.

    ``name`` is the full name of the node."""

    name = ""

    def state(self, text: str) -> None:
        raise NotImplementedError

    def events(self, texts: list[str]) -> None:
        raise NotImplementedError

    def wants_events(self) -> bool:
        """Whether events have a subscriber."""
        return True

    def wants_state(self) -> bool:
        """Whether the state has a subscriber."""
        return True

    def diagnostics(self, level: int, message: str, values: list[tuple[str, str]]) -> None:
        raise NotImplementedError

    def faults(self) -> list[str]:
        """Return the current faults outside the node, as texts."""
        return []

    def unconnected(self) -> list[str]:
        """Return the topics without a publisher or subscriber at the other end, as texts."""
        return []

    def values(self, messages: Sequence[Tuple[str, str, Any]]) -> None:
        """Publish the state as messages of standard types, if that is enabled."""

    def legacy(self, text: str) -> None:
        """Publish the state in the format of the original tool, if that is enabled."""
