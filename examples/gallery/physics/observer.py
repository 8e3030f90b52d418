"""Judges commands by what is said on the topics and what is true in the world.

It knows neither robosc nor any model. Messages of different topics reach a controller in no certain
order, and a command takes its time to come back. So a command counts as right if there was a moment
within the last ``TOLERANCE`` seconds of simulated time at which it was allowed.
"""

from __future__ import annotations

from collections import Counter, deque
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

__all__ = ["TOLERANCE", "Moment", "Observer"]

TOLERANCE = 0.2
"""Seconds: four steps of the simulation."""


@dataclass(frozen=True)
class Moment:
    """What was known at one time: when each topic was heard last, and facts of the world."""

    time: float
    heard: dict[str, float]
    facts: dict[str, Any]

    def fresh(self, topic: str, seconds: float) -> bool:
        """Whether a topic was heard within the last seconds."""
        return self.time - self.heard.get(topic, float("-inf")) <= seconds

    def __getitem__(self, fact: str) -> Any:
        return self.facts[fact]


class Observer:
    """Counts the judgements and the violations of each rule."""

    def __init__(self) -> None:
        self.judgements = 0
        self.violations: Counter[str] = Counter()
        self.times: dict[str, list[float]] = {}
        self._now = 0.0
        self._heard: dict[str, float] = {}
        self._facts: dict[str, Any] = {}
        self._moments: deque[Moment] = deque()

    def hear(self, topic: str, usable: bool = True) -> None:
        """A message of the robot was published; one that is not usable is worse than none."""
        self._heard = {**self._heard, topic: self._now if usable else float("-inf")}

    def note(self, **facts: Any) -> None:
        """Something else became true; what is noted before the first tick is from the start."""
        self._facts = {**self._facts, **facts}
        if self._now > 0.0:
            self._keep()

    def tick(self, now: float) -> None:
        """Time went on."""
        self._now = now
        self._keep()
        while self._moments[0].time < now - TOLERANCE:
            self._moments.popleft()

    def _keep(self) -> None:
        self._moments.append(Moment(self._now, self._heard, self._facts))

    def judge(self, rule: str, allowed: Callable[[Moment], bool]) -> None:
        """Judge a command that arrived now."""
        self.judgements += 1
        self._keep()
        if not any(map(allowed, self._moments)):
            self.violate(rule)

    def violate(self, rule: str) -> None:
        self.violations[rule] += 1
        self.times.setdefault(rule, []).append(self._now)
