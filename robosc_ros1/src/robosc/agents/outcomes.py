"""What became of a call, as an agent is told: the same words in the simulator and on a robot."""

from __future__ import annotations

import threading
from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass
from typing import Any

from robosc.runtime.reasons import reason_text

Json = Any


@dataclass(frozen=True)
class CallOutcome:
    """``word``: "sent", "corrected", "blocked", "refused", "answered", "failed", "cancelled" or
    "unknown". ``more`` are the details: ``why`` as text, ``blocked_by`` and ``corrected`` as
    docs/schemas has them, ``answer``, the data of the robot."""

    word: str
    more: Mapping[str, Json]

    @property
    def is_error(self) -> bool:
        """Whether the robot did not get what was asked for."""
        return self.word not in ("sent", "corrected", "answered", "cancelled")

    def document(self) -> dict[str, Json]:
        return {"outcome": self.word, **self.more}


def sent(correction: Mapping[str, Json] | None = None, **more: Json) -> CallOutcome:
    """A command that the supervisor let pass, as it was or corrected."""
    if correction is None:
        return CallOutcome("sent", more)
    return CallOutcome("corrected", {"corrected": dict(correction), **more})


def blocked(reasons: Iterable[Mapping[str, Json]], **more: Json) -> CallOutcome:
    """A command that the supervisor did not let pass."""
    found = [dict(reason) for reason in reasons]
    texts = [reason_text(reason) for reason in found]
    return CallOutcome("blocked", {"why": texts, "blocked_by": found, **more})


def unsent(word: str, why: str) -> CallOutcome:
    """A call of which nothing reached the robot, or of which nobody knows whether it did."""
    return CallOutcome(word, {"why": [why]})


class CallWatch:
    """How a call in another thread reports progress, and learns that its client cancelled it."""

    def __init__(self, report: Callable[[Json], None]) -> None:
        self.cancelled = threading.Event()
        self.report = report
