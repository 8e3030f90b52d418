"""What a recording tells of the time at which a message came, beside the time of the recorder.

A recorder, and the machine that it shares with the robot, may be late. A message was made at its
stamp, so it may have come at any time from then on, with the least age that its topic had before. A
burst of one topic had waited for the recorder. A silence that such a message ends later than it may
have come is none that anybody knows of.
"""

from __future__ import annotations

from collections import deque
from collections.abc import Iterable, Iterator
from functools import partial
from typing import Any

Recorded = tuple[str, float, "float | None", Any]
"""Topic, time of the recorder, seconds of the message's stamp (None: it has none), message."""

_LATEST = 2.0
"""Seconds by which a recorder may be late: so far is looked ahead."""
_BURST = 0.1
"""The part of the usual pause of a topic within which messages that had waited follow."""
_REMEMBERED = 50
"""Messages of a topic from which its usual pause and its least age are known."""
_KNOWN = 5
"""Pauses of a topic after which its usual one is known."""


class Lookahead:
    """The messages of a recording, one after the other, with those that follow; for ``timed``
    topics it matters when they came."""

    def __init__(self, messages: Iterable[Recorded], timed: Iterable[str]) -> None:
        self._messages = iter(messages)
        self._timed = frozenset(timed)
        self._ahead: deque[Recorded] = deque()
        latest = partial(deque[float], maxlen=_REMEMBERED)
        self._ages = {topic: latest() for topic in self._timed}
        self._pauses = {topic: latest() for topic in self._timed}
        self._last: dict[str, float] = {}

    def __iter__(self) -> Iterator[Recorded]:
        ahead = self._ahead
        if not self._timed:
            yield from self._messages
        for recorded in self._messages:
            ahead.append(recorded)
            topic, time, stamp, _ = recorded
            if topic in self._timed:
                self._note(topic, time, stamp)
            while ahead[0][1] + _LATEST <= time:
                yield ahead[0]
                ahead.popleft()
        while ahead:
            yield ahead[0]
            ahead.popleft()

    def may_have_come(self, topic: str, time: float) -> float | None:
        """The recorded time of the next message of a topic, if it may have come before a time;
        None: it cannot have, or there is none."""
        coming = ((t, stamp) for name, t, stamp, _ in self._ahead if name == topic)
        recorded, stamp = next(coming, (None, None))
        if recorded is None:
            return None
        if stamp is not None:
            return recorded if stamp + min(self._ages[topic]) <= time else None
        following, _ = next(coming, (None, None))
        pauses = self._pauses[topic]
        if following is None or len(pauses) < _KNOWN:
            return None
        usual = sorted(pauses)[len(pauses) // 2]
        return recorded if following - recorded < _BURST * usual else None

    def _note(self, topic: str, time: float, stamp: float | None) -> None:
        if stamp is not None:
            self._ages[topic].append(time - stamp)
        elif topic in self._last:
            self._pauses[topic].append(time - self._last[topic])
        self._last[topic] = time
