"""The role of a monitor that follows a recording, with a short way for messages that come alone."""

from __future__ import annotations

from typing import Any

from robosc.runtime.engine_parts import BoundInput
from robosc.runtime.monitoring import Monitoring
from robosc.runtime.values import UNREADABLE, Mismatch

_ROUNDING = 1e-6
"""Seconds, above what is lost by rounding times since 1970."""


class BagMonitoring(Monitoring):
    """Judges a recording. Most of its messages come while nothing else is to be done, and leave
    nothing to say: they need neither inbox nor queue, nor an entry of their own in the record."""

    def begin(self) -> None:
        super().begin()
        sorts = {c.sort for c in self._controller.COMMUNICATIONS}
        self._may_be_due = bool(self._invariants.rows) or "action" in sorts

    def is_idle_until(self, time: float) -> bool:
        """Whether nothing that was seen is still to be judged, and nothing is due until a time of
        the recording."""
        if self._pending.oldest is not None:
            return False
        span = time - self._parts.steady() + _ROUNDING
        left = self._parts.clocks.time_to_next()
        if left is not None and left <= span:
            return False
        left = self.due() if self._may_be_due else None
        return left is None or left > span

    def take(self, entry: BoundInput, message: Any) -> bool:
        """Apply an input that comes alone, as the engine would, but for its entry in the record;
        False: it cannot happen now, and nothing has changed."""
        orders = self._crossings.of(entry.key)
        before = None if orders is None else orders.moment()
        read = entry.read
        try:
            entry.apply(None if read is None else read(message))
        except (Mismatch, *UNREADABLE):
            return False
        self._engine.after(entry.writes, None)
        if orders is not None and before is not None:
            orders.happened(self._crossings.arrival((entry,), message), before)
        self._parts.clocks.heard((entry.key,), self._parts.steady())
        return True
