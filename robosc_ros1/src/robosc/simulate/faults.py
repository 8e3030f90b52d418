"""How a line can fail. None of these is a fault of the model or of robosc."""

from __future__ import annotations


class LineFault(Exception):
    """A line was not done; the message says why, and what to write instead where that is known."""

    kind = "wrong"


class InvalidLine(LineFault):
    """The line means nothing: an unknown name, a value of the wrong type."""


class Refused(LineFault):
    """The line means something that cannot happen now."""

    kind = "refused"


class Failed(LineFault):
    """An expectation is not met; the message says what is the case instead."""

    kind = "failed"
