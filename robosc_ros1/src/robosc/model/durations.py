"""Durations: of timeouts and of ``after``."""

from __future__ import annotations

import math

from robosc.language.keywords import UNITS
from robosc.model.expr import Literal
from robosc.model.report import Report
from robosc.model.types import DoubleType
from robosc.syntax.nodes import DurationNode, ExprNode

__all__ = ["resolve_duration"]


def resolve_duration(node: ExprNode, report: Report) -> Literal | None:
    """The duration in seconds; None after an error."""
    if not isinstance(node, DurationNode):
        report.add(
            "type-mismatch",
            node.span,
            "a duration is needed here",
            "write a number with a unit: 500 ms, 0.5 s, 2 min or 1 h",
        )
        return None
    seconds = float(node.amount) * UNITS[node.unit]
    if not (0.0 < seconds < math.inf):
        report.add(
            "out-of-range", node.span, "a duration must be above 0 and finite", "write: 500 ms"
        )
        return None
    return Literal(seconds, DoubleType(), node.span)
