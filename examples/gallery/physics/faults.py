"""What goes wrong in a run: planted by the seed, known to nobody but the bridge."""

from __future__ import annotations

import random
from collections.abc import Iterable
from dataclasses import dataclass

__all__ = ["Faults"]

SILENCE = 2.0
KILLED = 2.0
LATE = 0.5


@dataclass(frozen=True)
class Faults:
    """Times in seconds: topics that are silent from one to the other, action servers that are not
    there, and how late answers come."""

    silences: tuple[tuple[str, float, float], ...] = ()
    kills: tuple[tuple[str, float, float], ...] = ()
    late: float = 0.0

    @classmethod
    def planted(cls, seed: int, sensors: Iterable[str], actions: Iterable[str]) -> Faults:
        """Return the faults of a seed: one silence, and of an action one kill and late answers."""
        choice = random.Random(1000 + seed)
        silences = []
        for topic in choice.sample(sorted(sensors), min(1, len(list(sensors)))):
            begin = choice.uniform(2.0, 6.0)
            silences.append((topic, begin, begin + SILENCE))
        kills = []
        for action in choice.sample(sorted(actions), min(1, len(list(actions)))):
            begin = choice.uniform(5.0, 10.0)
            kills.append((action, begin, begin + KILLED))
        return cls(tuple(silences), tuple(kills), LATE if kills else 0.0)

    def is_silent(self, topic: str, now: float) -> bool:
        return any(topic == t and begin <= now < end for t, begin, end in self.silences)

    def is_killed(self, action: str, now: float) -> bool:
        return any(action == a and begin <= now < end for a, begin, end in self.kills)

    @property
    def over(self) -> float:
        """When the last of them has passed."""
        return max((end for _, _, end in (*self.silences, *self.kills)), default=0.0)

    @property
    def texts(self) -> list[str]:
        """Say what is planted."""
        silent = [f"{t} silent {a:.1f}-{b:.1f} s" for t, a, b in self.silences]
        killed = [f"{t} killed {a:.1f}-{b:.1f} s" for t, a, b in self.kills]
        return silent + killed + ([f"answers {self.late:g} s late"] if self.late else [])
