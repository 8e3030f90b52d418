"""What happened, and how often: the engine's notes for those who report."""

from __future__ import annotations

import time
from collections import deque
from typing import Any, Callable, Deque, Dict, List, NamedTuple, Optional

__all__ = ["Entry", "Journal", "Throttle"]

_CAPACITY = 50000


class Entry(NamedTuple):
    """One event. ``outcome`` is "applied", "mismatch", "failed" or "stopped";
    ``tau`` is the number of a component's own step, else 0."""

    number: int
    time: float
    kind: str
    name: str
    tau: int
    value: Any
    outcome: str
    detail: Optional[str]


class Journal:
    """The latest events, for a reporter to take; and counters, which never forget."""

    def __init__(self, now: Callable[[], float] = time.time) -> None:
        self._now = now
        self._entries: Deque[Entry] = deque(maxlen=_CAPACITY)
        self.counters: Dict[str, int] = {
            "inputs": 0, "commands": 0, "taus": 0, "errors": 0, "mismatches": 0, "undefined": 0,
            "failed": 0, "late": 0,
        }  # fmt: skip
        self.number = 0

    def note(
        self,
        kind: str,
        name: str,
        value: Any = None,
        outcome: str = "applied",
        detail: Optional[str] = None,
        tau: int = 0,
    ) -> None:
        self.number += 1
        self._entries.append(
            Entry(self.number, self._now(), kind, name, tau, value, outcome, detail)
        )

    def take(self) -> List[Entry]:
        """All entries since the last call; gaps in their numbers tell what had to be dropped."""
        taken = []
        while True:
            try:
                taken.append(self._entries.popleft())
            except IndexError:
                return taken


class Throttle:
    """Lets one message per subject and period through, and counts those held back."""

    def __init__(self, period: float = 1.0) -> None:
        self._period = period
        self._last: Dict[str, float] = {}
        self._held: Dict[str, int] = {}

    def __call__(self, subject: str, text: str, now: float) -> Optional[str]:
        """The text to log now, or None."""
        last = self._last.get(subject)
        if last is not None and now - last < self._period:
            self._held[subject] = self._held.get(subject, 0) + 1
            return None
        self._last[subject] = now
        held = self._held.pop(subject, 0)
        return "%s (%d more since the last report)" % (text, held) if held else text
