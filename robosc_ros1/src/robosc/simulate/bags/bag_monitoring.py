"""The role of a monitor that follows a recording, with a short way for messages that come alone."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any

from robosc.runtime.core.engine_parts import BoundInput
from robosc.runtime.core.values import UNREADABLE, Mismatch
from robosc.runtime.judge.matching import CommandPattern, matching_command
from robosc.runtime.judge.monitoring import Monitoring

_ROUNDING = 1e-6
"""Seconds, above what is lost by rounding times since 1970."""


ShortWay = Callable[[Any], "int | None"]
"""Takes a message that comes alone, and returns how many events it was that are not recorded, since
there is nothing to say of them; None: it has to go through the engine, and nothing has changed."""


class BagMonitoring(Monitoring):
    """Judges a recording. Most of its messages come while nothing is due by the clock: they need
    neither inbox nor queue."""

    def _span(self) -> float:
        return self.tolerance  # a recording does not tell how late its node was

    def begin(self) -> None:
        super().begin()
        sorts = {c.sort for c in self._controller.COMMUNICATIONS}
        self._has_clocks = bool(self._parts.clocks.delays)
        self._may_be_due = bool(self._invariants.rows) or "action" in sorts

    def is_idle_until(self, time: float) -> bool:
        """Whether nothing is due until a time of the recording."""
        span = time - self._parts.steady() + _ROUNDING
        left = self._parts.clocks.time_to_next() if self._has_clocks else None
        if left is not None and left <= span:
            return False
        left = self.due() if self._may_be_due or self._pending.oldest is not None else None
        return left is None or left > span

    def short_way(self, entry: BoundInput) -> ShortWay:
        """Return what applies an input as the engine would, but for its entry in the record."""
        engine, clocks, crossings = self._engine, self._parts.clocks, self._crossings
        state, read, apply, writes = vars(self._controller), entry.read, entry.apply, entry.writes
        keys, orders = (entry.key,), crossings.of(entry.key)
        is_watched, pending = clocks.is_watched(entry.key), self._pending

        def take(message: Any) -> int | None:
            before = None if orders is None else orders.moment()
            values = [state[name] for name in writes]
            try:
                apply(None if read is None else read(message))
            except (Mismatch, *UNREADABLE):
                return None
            for name, value in zip(writes, values, strict=True):
                if state[name] is not value:
                    engine.after(writes, None)
                    break
            if orders is not None and before is not None:
                orders.happened(crossings.arrival((entry,), message), before)
            if is_watched:
                clocks.heard(keys, self._parts.steady())
            if pending.oldest is not None:
                pending.judge(self._answer)
            return 1

        return take

    def short_way_of_commands(self, topic: str, patterns: Sequence[CommandPattern]) -> ShortWay:
        """Return what takes the commands of a topic as :meth:`offer` does."""

        def take(message: Any) -> int | None:
            key = matching_command(patterns, message)
            if key is None:
                return None
            self._pending.name_topic(key, topic)
            self._take_command(key, "request", message)
            return 0

        return take
