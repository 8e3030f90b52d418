"""How often each event occurred, and the counters of ``~state``, from the events alone."""

from __future__ import annotations

from collections import Counter

from robosc.language.events import EventKind
from robosc.model import entities


class Tally:
    """Counts the events of one run: ``counts`` those that were applied, by name and kind."""

    def __init__(self, robot: entities.Robot) -> None:
        self._robot = robot
        self.counts: Counter[tuple[str, str]] = Counter()
        self.counters = dict.fromkeys(
            ("inputs", "commands", "taus", "errors", "mismatches", "undefined", "failed", "late"), 0
        )

    def take(self, kind: str, name: str, outcome: str) -> None:
        if outcome in ("stopped", "violated", "refused", "withheld", "operated"):
            return
        if outcome in ("mismatch", "failed"):
            self.counters["mismatches" if outcome == "mismatch" else "failed"] += 1
            return
        self.counts[name, kind] += 1
        if kind == EventKind.TAU.word:
            self.counters["taus"] += 1
        elif self._robot.decides(kind, name):
            self.counters["commands"] += 1
        else:
            self.counters["inputs"] += 1
            self.counters["errors"] += kind == EventKind.ERROR.word
