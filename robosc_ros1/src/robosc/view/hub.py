"""What there is to see now, for any number of followers, each at its own pace.

States replace one another: a follower that is slow sees fewer of them. Events are kept for a while
and counted, so that a follower which falls behind learns how many it missed. Nobody who follows
can hold up the one who puts.
"""

from __future__ import annotations

import json
import threading
from collections import deque
from collections.abc import Iterable

from robosc import limits

_AT_FIRST = 200
"""Events that a new follower gets."""


class Hub:
    """Named documents, of which the latest counts, and a stream of events; all as JSON text."""

    def __init__(self) -> None:
        self._changed = threading.Condition()
        self._latest: dict[str, tuple[int, str]] = {}
        self._events: deque[str] = deque()
        self._length = 0
        self._added = 0
        self._cleared = 0
        self._version = 0

    def put(self, name: str, text: str) -> None:
        """Replace a document. One that is the same as before disturbs nobody."""
        with self._changed:
            if name in self._latest and self._latest[name][1] == text:
                return
            self._version += 1
            self._latest[name] = self._version, text
            self._changed.notify_all()

    def add(self, events: Iterable[str]) -> None:
        with self._changed:
            before = self._added
            for event in events:
                self._events.append(event)
                self._length += len(event)
                self._added += 1
                while (
                    len(self._events) > limits.KEPT_EVENTS or self._length > limits.KEPT_CHARACTERS
                ):
                    self._length -= len(self._events.popleft())
            if self._added > before:
                self._changed.notify_all()

    def clear(self) -> None:
        """Forget all events: another run begins, and followers are notified ("run")."""
        with self._changed:
            self._events.clear()
            self._length = 0
            self._cleared = self._added
            self._version += 1
            self._latest["run"] = self._version, str(self._version)
            self._changed.notify_all()

    def follow(self) -> HubFollower:
        return HubFollower(self)

    def news(self, version: int, seen: int, timeout: float) -> tuple[str | None, int, int]:
        """What came after a version and a number of events, as one document; None if nothing did.

        With the version and the number that the next question has to start from.
        """
        with self._changed:
            self._changed.wait_for(lambda: self._version > version or self._added > seen, timeout)
            parts = [
                f'"{name}":{text}' for name, (at, text) in self._latest.items() if at > version
            ]
            if seen < 0:
                seen = max(self._cleared, self._added - _AT_FIRST)
            seen = max(seen, self._cleared)
            first = self._added - len(self._events)
            if first > seen:
                parts.append(f'"dropped":{first - seen}')
            if self._added > seen:
                begin = max(seen, first) - first
                count = len(self._events)
                new = ",".join(self._events[i] for i in range(begin, count))
                parts.append(f'"events":[{new}]')
            text = "{" + ",".join(parts) + "}" if parts else None
            return text, self._version, self._added


class HubFollower:
    """One who follows. Not to be shared between threads."""

    def __init__(self, hub: Hub) -> None:
        self._hub = hub
        self._version = 0
        self._seen = -1

    def take(self, timeout: float) -> str | None:
        """Everything new since the last call, as one JSON object: documents by name, ``events``
        oldest first, and ``dropped``, the number of those that were missed. None after a timeout.
        """
        text, self._version, self._seen = self._hub.news(self._version, self._seen, timeout)
        return text


def compact(document: object) -> str:
    """JSON on one line, as a stream needs it."""
    return json.dumps(document, separators=(",", ":"), ensure_ascii=False)


def utf8(text: str) -> bytes:
    """JSON as bytes. Half of a surrogate pair, which a log may have, stays an escape in it."""
    return text.encode("utf-8", "backslashreplace")
