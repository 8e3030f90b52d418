"""Typing of durations: of timeouts, ``after``, constants and parameters, and in data."""

from __future__ import annotations

import math

from robosc.expr import tree, types
from robosc.language.keywords import UNITS
from robosc.model.diagnostics import Report
from robosc.model.ros.object_types import DURATIONS
from robosc.model.typing.expected import expected_type
from robosc.runtime.core.settings import SHORTEST_DURATION
from robosc.source import Span
from robosc.syntax.nodes import DurationNode, UnaryNode

DURATION = expected_type(types.DurationType())
"""The expected type of a timeout and of ``after``."""


def signed_duration(node: object) -> DurationNode | None:
    """The duration of a node that is one or the negative of one, its amount signed; else None."""
    match node:
        case DurationNode():
            return node
        case UnaryNode(operator="-", operand=DurationNode(amount=amount, unit=unit)):
            return DurationNode(-amount, unit, span=node.span)
    return None


def typed_duration(node: DurationNode, report: Report) -> tree.Literal | None:
    """A duration in seconds, perhaps negative; None after a reported error."""
    seconds = float(node.amount) * UNITS[node.unit]
    if math.isinf(seconds):
        report.add("out-of-range", node.span, "a duration must be finite", "write: 500 ms")
        return None
    return tree.Literal(seconds, types.DurationType(), node.span)


def is_long_enough(duration: tree.Expr, what: str, span: Span, report: Report) -> bool:
    """Whether a duration that somebody waits for is one, or no literal; reports an error if not."""
    if not isinstance(duration, tree.Literal) or float(duration.value) >= SHORTEST_DURATION:
        return True
    message = f"{what} must be at least {SHORTEST_DURATION * 1000:g} ms"
    report.add("out-of-range", span, message, "write: 500 ms")
    return False


def duration_fields(node: DurationNode, type_: str) -> dict[str, int]:
    """The fields of a duration as a message of ROS: whole seconds and nanoseconds."""
    nanoseconds = round(node.amount * UNITS[node.unit] * 10**9)
    return dict(zip(DURATIONS[type_], divmod(nanoseconds, 10**9), strict=True))
