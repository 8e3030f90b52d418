"""A recording, of one file or of several: its channels, and its messages in order."""

from __future__ import annotations

import time as clock
from array import array
from bisect import bisect
from collections import Counter
from collections.abc import Collection, Iterable, Iterator, Mapping, Sequence
from dataclasses import replace
from datetime import datetime, timezone
from itertools import pairwise
from typing import Any

from robosc.errors import counted
from robosc.lazy_dataclasses import dataclass
from robosc.progress import Progress
from robosc.simulate.bags.storage import Channel, Damaged, Storage

# The time of each recorded message on one line that goes on, whatever the recorder's clock
# did.


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


_NANOSECONDS = 1_000_000_000
_FILE = 32
"""Bits of the number of a channel or a chunk within its file."""
_OWN = (1 << _FILE) - 1
_EARLY = 946_684_800
"""Seconds until the year 2000: what was recorded before had no clock of its own."""
_SHOWN = 3


class BagStorage:
    """A recording that is open. Channels have numbers; times are in seconds since 1970.

    ``notes`` say what there is to know of the file; ``missing`` what should be in the recording,
    and is not. ``promised`` are the messages of each topic as the recording's description has
    them.
    """

    def __init__(
        self,
        files: Sequence[tuple[str, Storage]],
        promised: Mapping[str, int],
        *,
        notes: Sequence[str] = (),
        missing: Sequence[str] = (),
    ) -> None:
        self._files = [storage for _, storage in files]
        self._names = [name for name, _ in files]
        self.notes = list(notes)
        self.missing = list(missing)
        self.channels: dict[int, Channel] = {}
        for number, storage in enumerate(self._files):
            for own, channel in storage.contents.channels.items():
                self.channels[(number << _FILE) + own] = replace(
                    channel, topic=f"/{channel.topic.lstrip('/')}"
                )
        raw, self._channels = array("Q"), array("Q")
        self._chunks, self._places = array("Q"), array("Q")
        for number, storage in enumerate(self._files):
            index, file = storage.contents.index, number << _FILE
            raw.extend(index.times)
            self._channels.extend(index.channels if not number else _plus(file, index.channels))
            self._chunks.extend(index.chunks if not number else _plus(file, index.chunks))
            self._places.extend(index.places)
        self._times, jumps = continued(raw, self._channels)
        self.counts = Counter(n for n in self._channels if n in self.channels)
        self._compare(promised)
        self._tell(jumps, raw)

    @property
    def ros_1(self) -> bool:
        return any(channel.encoding == "ros1" for channel in self.channels.values())

    @property
    def span(self) -> tuple[float, float]:
        """The first and the last time; zeros if there is no message."""
        if not self._times:
            return 0.0, 0.0
        return min(self._times) / _NANOSECONDS, max(self._times) / _NANOSECONDS

    def close(self) -> None:
        for storage in self._files:
            storage.close()

    def times(self, number: int) -> list[float]:
        """The times of the messages of a channel in order, in seconds since the first of all."""
        found = zip(self._times, self._channels, strict=True)
        start = min(self._times, default=0)
        return sorted((t - start) / _NANOSECONDS for t, channel in found if channel == number)

    def messages(
        self, wanted: Collection[int], progress: Progress
    ) -> Iterator[tuple[int, float, bytes]]:
        """The messages of some channels in the order of their times, those of one time as they were
        written: channel, time, bytes. It ends where the recording is damaged."""
        numbers = [n for n, channel in enumerate(self._channels) if channel in wanted]
        times, channels, chunks, places = self._times, self._channels, self._chunks, self._places
        numbers.sort(key=times.__getitem__)
        left = Counter(map(chunks.__getitem__, numbers))
        loaded: dict[int, Any] = {}  # each chunk once, until its last message was read
        for count, number in enumerate(numbers):
            if not count % 256:
                progress("reading messages", count, len(numbers))
            chunk = chunks[number]
            storage = self._files[chunk >> _FILE]
            try:
                if chunk not in loaded:
                    loaded[chunk] = storage.load(chunk & _OWN)
                raw = storage.message(loaded[chunk], places[number])
            except Damaged as damage:
                lost = counted(len(numbers) - count, "message")
                self.missing.append(f"{damage}: {lost} from there on cannot be read")
                return
            yield channels[number], times[number] / _NANOSECONDS, raw
            left[chunk] -= 1
            if not left[chunk]:
                del loaded[chunk]

    # --- what is told ----------------------------------------------------------------------------

    def _compare(self, promised: Mapping[str, int]) -> None:
        """Tell what the files lack of what they and the description of the recording promise."""
        read = Counter[str]()
        for number, count in self.counts.items():
            read[self.channels[number].topic] += count
        expected = Counter({f"/{topic.lstrip('/')}": n for topic, n in promised.items()})
        own = Counter[str]()
        for number, storage in enumerate(self._files):
            for channel, count in storage.contents.promised.items():
                own[self.channels[(number << _FILE) + channel].topic] += count
        left_out: dict[str, str] = {}
        for name, storage in zip(self._names, self._files, strict=True):
            if storage.contents.cut:
                self.notes.append(f"{name} is read as far as it goes: {storage.contents.cut}")
            left_out.update(storage.contents.left_out)
        if left_out:
            forms = ", ".join(f"{topic} ({form})" for topic, form in sorted(left_out.items()))
            self.notes.append(f"left out, since it is not in a form of ROS: {forms}")
        lacking = [
            f"{topic} ({read[topic]:,} of {count:,})"
            for topic, count in sorted((expected | own).items())
            if read[topic] < count and topic not in left_out
        ]
        if lacking:
            self.missing.append(f"fewer messages than the recording states: {', '.join(lacking)}")

    def _tell(self, jumps: Sequence[Jump], raw: Sequence[int]) -> None:
        if not raw:
            return
        start, _ = self.span
        if jumps:
            said = [
                f"by {jump.by / _NANOSECONDS:+,.3f} s at"
                f" {self._times[jump.at] / _NANOSECONDS - start:.3f} s"
                for jump in jumps[:_SHOWN]
            ]
            more = f" and {len(jumps) - _SHOWN} times more" if len(jumps) > _SHOWN else ""
            self.notes.append(
                f"the recorded times jump {', '.join(said)}{more}: time goes on from there"
            )
        if start < _EARLY:
            self.notes.append(
                f"the recorded times begin at {_date(start)}: simulated time, or a clock that was"
                " not set"
            )
        elif start > clock.time() + 86_400:
            self.notes.append(f"the recorded times lie in the future: they begin at {_date(start)}")


def _plus(file: int, numbers: Iterable[int]) -> Iterator[int]:
    return (file + number for number in numbers)


def _date(seconds: float) -> str:
    if seconds > 253_402_300_799:  # the last of the year 9999
        return f"{seconds:.0f} s after 1970"
    return datetime.fromtimestamp(seconds, timezone.utc).strftime("%Y-%m-%d")
