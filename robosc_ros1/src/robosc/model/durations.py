"""Durations: of timeouts, of ``after``, of constants and parameters, and in data that is sent."""

from __future__ import annotations

import math

from robosc.language.keywords import UNITS
from robosc.model.diagnostics import Report
from robosc.model.expected import expected_type
from robosc.model.expr import Literal
from robosc.model.ros.types import DURATIONS
from robosc.model.types import DurationType
from robosc.syntax.nodes import DurationNode

__all__ = ["DURATION", "duration_fields", "typed_duration"]

DURATION = expected_type(DurationType())
"""What a timeout and ``after`` need."""


def typed_duration(node: DurationNode, report: Report) -> Literal | None:
    """A number with a unit as seconds; None after an error."""
    seconds = float(node.amount) * UNITS[node.unit]
    if not (0.0 < seconds < math.inf):
        report.add(
            "out-of-range", node.span, "a duration must be above 0 and finite", "write: 500 ms"
        )
        return None
    return Literal(seconds, DurationType(), node.span)


def duration_fields(node: DurationNode, type_: str) -> dict[str, int]:
    """A duration as the message that ROS has for it: whole seconds and nanoseconds."""
    nanoseconds = round(node.amount * UNITS[node.unit] * 10**9)
    return dict(zip(DURATIONS[type_], divmod(nanoseconds, 10**9), strict=True))
