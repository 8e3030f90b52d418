"""The table of reasons: the words that ``reason`` may be in ``on error from``."""

from __future__ import annotations

from robosc.language.events import Kind
from robosc.lazy_dataclasses import dataclass


@dataclass(frozen=True, slots=True)
class ErrorReason:
    """Why a service or an action failed, as models name it.

    ``of_services``: services fail for it, too. ``while_cancelling``: also what is being cancelled
    does. ``meaning`` continues "the request failed: …".
    """

    word: str
    of_services: bool
    while_cancelling: bool
    meaning: str


REFUSED = "refused"
"""The reason of an answer for which ``expect:`` does not hold, or which breaks an assumption; the
answer is its value."""
FAILED = "failed"
"""The reason of a goal that its server has ended, perhaps with a result."""

REASONS = (
    ErrorReason(
        FAILED, True, True, "its server aborted it, raised an exception, or others ended it"
    ),
    ErrorReason("absent", True, False, "there was no server until the deadline"),
    ErrorReason("rejected", False, False, "the server did not accept the goal"),
    ErrorReason(
        REFUSED, True, True, "the answer is not what `expect:` says, or breaks an assumption"
    ),
    ErrorReason("timeout", True, False, "it was not answered, not accepted or not done in time"),
    ErrorReason("lost", False, True, "the server vanished, or was silent for too long"),
)
"""All reasons; the first one is what simulated errors have if nothing else is said."""


def reasons_of(kind: Kind) -> tuple[str, ...]:
    """Return the reasons for which a kind of communication fails; none if it has no errors."""
    if kind is Kind.ACTION:
        return tuple(reason.word for reason in REASONS)
    return tuple(r.word for r in REASONS if r.of_services) if kind is Kind.SERVICE else ()
