"""The role of a monitor that follows a recording, with a short way for messages that come alone."""

from __future__ import annotations

from collections.abc import Callable
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
        self._has_clocks = bool(self._parts.clocks.delays)
        self._may_be_due = bool(self._invariants.rows) or "action" in sorts

    def is_idle_until(self, time: float) -> bool:
        """Whether nothing that was seen is still to be judged, and nothing is due until a time of
        the recording."""
        if self._pending.oldest is not None:
            return False
        span = time - self._parts.steady() + _ROUNDING
        left = self._parts.clocks.time_to_next() if self._has_clocks else None
        if left is not None and left <= span:
            return False
        left = self.due() if self._may_be_due else None
        return left is None or left > span

    def short_way(self, entry: BoundInput) -> Callable[[Any], bool]:
        """Return what applies an input that comes alone, as the engine would, but for its entry in
        the record; False: it cannot happen now, and nothing has changed."""
        engine, clocks, crossings = self._engine, self._parts.clocks, self._crossings
        state, read, apply, writes = vars(self._controller), entry.read, entry.apply, entry.writes
        keys, orders = (entry.key,), crossings.of(entry.key)
        is_watched = clocks.is_watched(entry.key)

        def take(message: Any) -> bool:
            before = None if orders is None else orders.moment()
            values = [state[name] for name in writes]
            try:
                apply(None if read is None else read(message))
            except (Mismatch, *UNREADABLE):
                return False
            for name, value in zip(writes, values, strict=True):
                if state[name] is not value:
                    engine.after(writes, None)
                    break
            if orders is not None and before is not None:
                orders.happened(crossings.arrival((entry,), message), before)
            if is_watched:
                clocks.heard(keys, self._parts.steady())
            return True

        return take
