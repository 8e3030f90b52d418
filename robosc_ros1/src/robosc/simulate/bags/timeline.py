"""The time of each recorded message on one line that goes on, whatever the recorder's clock did."""

from __future__ import annotations

from array import array
from bisect import bisect
from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise

_SECOND = 1_000_000_000
_PAUSE = 3600 * _SECOND
"""Between two messages that follow each other in time: a longer one is a jump of the clock, or a
pause of the recorder. Nothing is known of what happened in it."""
_BACK = _SECOND
"""Messages of one topic that were written one after the other are not later by more than this,
unless the clock was set back."""


@dataclass(frozen=True)
class Jump:
    """The recorded times go on elsewhere: from message number ``at``, by so many nanoseconds."""

    at: int
    by: int


def continued(
    times: Sequence[int], channels: Sequence[int]
) -> tuple[Sequence[int], Sequence[Jump]]:
    """Return the times of messages, given in the order in which they were written, on one line, and
    where the clock jumped; in nanoseconds.

    The part with the most messages keeps its times. Files that were written topic by topic are in
    order: within a topic the time does not jump.
    """
    begins = _parts(times)
    if len(begins) < 2 and not _goes_back(times, channels):
        return times, ()
    walk = _Walk(begins)
    found = [walk.take(time, channel) for time, channel in zip(times, channels, strict=True)]
    shift = walk.shift
    return array("q", [max(0, time - shift) for time in found]), walk.jumps


def _parts(times: Sequence[int]) -> list[int]:
    """The first time of each part that lies apart from all others."""
    ordered = sorted(times)
    return [*ordered[:1], *(b for a, b in pairwise(ordered) if b - a > _PAUSE)]


def _goes_back(times: Sequence[int], channels: Sequence[int]) -> bool:
    last: dict[int, int] = {}
    for time, channel in zip(times, channels, strict=True):
        if time < last.get(channel, 0) - _BACK:
            return True
        last[channel] = time
    return False


class _Walk:
    """A walk through the messages as they were written: ``offset`` is what is added to the times
    now, those of ``_offsets`` are what was added before."""

    def __init__(self, begins: Sequence[int]) -> None:
        self._begins = begins
        self._part = -1
        self._offset = 0
        self._offsets: list[int] = [0]
        self._last: dict[int, int] = {}
        self._now = 0
        self._raw = 0
        self._number = 0
        self._counts = Counter[int]()
        self.jumps: list[Jump] = []

    @property
    def shift(self) -> int:
        """What is added to the times of most messages."""
        return self._counts.most_common(1)[0][0] if self._counts else 0

    def take(self, time: int, channel: int) -> int:
        part = bisect(self._begins, time)
        if self._part == -1:
            self._part, self._now = part, time
        if (
            part != self._part
            or time < self._last.get(channel, 0) - _BACK
            or (time + self._offset > self._now + _BACK and self._known(time) is not None)
        ):
            self._jump(time)
            self._part = part
        self._last[channel] = time
        self._number += 1
        self._raw = time
        self._counts[self._offset] += 1
        found = time + self._offset
        self._now = max(self._now, found)
        return found

    def _jump(self, time: int) -> None:
        self.jumps.append(Jump(self._number, time - self._raw))
        known = self._known(time)
        self._offset = self._now - time if known is None else known
        if known is None:
            self._offsets.append(self._offset)
        self._last.clear()

    def _known(self, time: int) -> int | None:
        """The offset of a clock that the recorder had before, if time goes on by that."""
        near = (o for o in self._offsets if abs(time + o - self._now) <= _BACK)
        return next(near, None)
