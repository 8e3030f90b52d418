"""How far a controller has come, by what it says on ``~model`` and ``~events``.

By this the bridge knows what is still under way, so that simulated time waits for it.
"""

from __future__ import annotations

import json
from collections import Counter
from typing import Any

__all__ = ["Progress"]


class Progress:
    """Counts by the ROS names of topics and actions, not by the model's."""

    def __init__(self) -> None:
        self._identifiers: dict[str, str] = {}
        self.taken: Counter[str] = Counter()
        """Messages, and ends of goals, that the controller has taken."""
        self.judged: Counter[str] = Counter()
        """Commands that a supervisor has passed on or blocked."""
        self.under_way: Counter[str] = Counter()
        """Messages and goals that it has sent, less those that have arrived; below zero if what it
        says comes later than what it sends."""
        self.active: set[str] = set()
        """The actions that it waits for the end of."""
        self.going: set[str] = set()
        """The actions whose goal has not ended, though it may have been cancelled."""
        self.cancelled: set[str] = set()
        """The actions whose goal it has cancelled, and not begun anew."""

    @property
    def is_known(self) -> bool:
        """Whether the controller has said what its names mean."""
        return bool(self._identifiers)

    def on_model(self, message: Any) -> None:
        communications = json.loads(message.data)["communications"]
        self._identifiers = {c["name"]: c["identifier"] for c in communications}

    def topic(self, name: str) -> str:
        """Return the ROS name of what the model calls so."""
        return self._identifiers[name]

    def on_event(self, message: Any) -> None:
        document = json.loads(message.data)
        kind, name = (document["event"][field] for field in ("kind", "name"))
        name = self._identifiers.get(name)
        if name is None:
            return  # of time, or before the model came
        if kind in ("response", "error", "cancelled"):
            self.going.discard(name)
        if kind in ("response", "error"):
            self.taken[name] += 1
            self._end(name)
        elif kind == "cancel":
            self.cancelled.add(name)
            self._end(name)
        elif kind == "request" and document["outcome"] == "applied":
            self.judged[name] += 1
            self.under_way[name] += 1
            self.active.add(name)
            self.going.add(name)
            self.cancelled.discard(name)

    def on_blocked(self, message: Any) -> None:
        event = json.loads(message.data)["event"]
        if event["kind"] == "request":
            self.judged[self._identifiers.get(event["name"], "")] += 1

    def _end(self, name: str) -> None:
        """A goal is over; if it has not arrived, it will not."""
        if name in self.active:
            self.active.discard(name)
            self.under_way[name] = min(0, self.under_way[name])
