"""What comments and docstrings of a generated controller say about events and phases."""

from __future__ import annotations

from robosc.language.events import EventKind
from robosc.model.entities import Communication

PERMITTED = {
    EventKind.REQUEST: "requested",
    EventKind.CANCEL: "cancelled",
    EventKind.ANSWER: "answered",
    EventKind.REFUSAL: "answered with an error",
    EventKind.PROGRESS: "reported on",
}
"""What a command may be done with."""

PHASES = {
    "busy": "is under way",
    "cancelling": "was cancelled, and has not ended",
    "ending": "was cancelled, and is not answered yet",
    "fresh": "came within its timeout",
    "silent": "came, but not within its timeout",
    "heard": "has come",
}
"""What it means that a communication is in a phase."""


def described(kind: EventKind, communication: Communication) -> str:
    """Return what an event is: ``response of the service call``."""
    if kind is EventKind.CANCELLED:
        return f"end of the cancelled action {communication.name}"
    return f"{kind.word} of the {communication.kind.value} {communication.name}"
