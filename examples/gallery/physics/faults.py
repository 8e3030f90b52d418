"""What goes wrong in a run: planted by the seed, known to nobody but the bridge."""

from __future__ import annotations

import math
import random
from collections.abc import Iterable
from dataclasses import dataclass

__all__ = ["Faults"]

SILENCE = 2.0
UNUSABLE = {
    "empty": [],
    "not numbers": [float("nan")],
    "zero": [0.0],
    "too near": [0.01],
    "infinite": [float("inf")],
}
"""Scans that say nothing, by the ranges of one beam."""
EACH = 0.4
"""Seconds for which a scanner sends each of them."""
KILLED = 2.0
LATE = 0.5


@dataclass(frozen=True)
class Faults:
    """Times in seconds: topics that are silent from one to the other, action servers that are not
    there, how late answers come, and from when on the scans of a scanner are unusable."""

    silences: tuple[tuple[str, float, float], ...] = ()
    kills: tuple[tuple[str, float, float], ...] = ()
    late: float = 0.0
    unusable: tuple[tuple[str, float], ...] = ()

    @classmethod
    def planted(
        cls, seed: int, sensors: Iterable[str], actions: Iterable[str], scanners: Iterable[str]
    ) -> Faults:
        """Return the faults of a seed: one silence, of an action one kill and late answers, and of
        each scanner unusable scans."""
        choice = random.Random(1000 + seed)
        silences = []
        for topic in choice.sample(sorted(sensors), min(1, len(list(sensors)))):
            begin = choice.uniform(2.0, 6.0)
            silences.append((topic, begin, begin + SILENCE))
        kills = []
        for action in choice.sample(sorted(actions), min(1, len(list(actions)))):
            begin = choice.uniform(5.0, 10.0)
            kills.append((action, begin, begin + KILLED))
        unusable = tuple((topic, choice.uniform(6.0, 9.0)) for topic in sorted(scanners))
        return cls(tuple(silences), tuple(kills), LATE if kills else 0.0, unusable)

    def is_silent(self, topic: str, now: float) -> bool:
        return any(topic == t and begin <= now < end for t, begin, end in self.silences)

    def ranges(self, topic: str, now: float) -> list[float] | None:
        """The ranges of one beam while a scan is unusable; None while it is as it should be."""
        for scanner, begin in self.unusable:
            number = math.floor((now - begin) / EACH)
            if topic == scanner and 0 <= number < len(UNUSABLE):
                return list(UNUSABLE.values())[number]
        return None

    def is_killed(self, action: str, now: float) -> bool:
        return any(action == a and begin <= now < end for a, begin, end in self.kills)

    @property
    def over(self) -> float:
        """When the last of them has passed."""
        ends = [end for _, _, end in (*self.silences, *self.kills)]
        ends += [begin + EACH * len(UNUSABLE) for _, begin in self.unusable]
        return max(ends, default=0.0)

    @property
    def texts(self) -> list[str]:
        """Say what is planted."""
        silent = [f"{t} silent {a:.1f}-{b:.1f} s" for t, a, b in self.silences]
        killed = [f"{t} killed {a:.1f}-{b:.1f} s" for t, a, b in self.kills]
        blind = [f"{t} unusable from {begin:.1f} s" for t, begin in self.unusable]
        return silent + killed + blind + ([f"answers {self.late:g} s late"] if self.late else [])
