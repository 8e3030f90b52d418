# Part of every package whose model computes so; the same file in all of them.
"""What controllers compute with, beside the functions of the language: arithmetic, and parts of
data that may be missing."""

from __future__ import annotations

import copy
import math
from typing import Any, Callable

from .values import NOW, Mismatch, Undefined, Value, widen


def divide(left: float, right: float) -> float:
    """Return the IEEE 754 quotient: x/0 is an infinity or NaN, never an error."""
    numerator, denominator = widen(left), widen(right)
    if denominator != 0.0:
        return numerator / denominator
    if numerator == 0.0 or math.isnan(numerator):
        return math.nan
    return math.copysign(math.inf, numerator) * math.copysign(1.0, denominator)


def remainder(left: Value, right: Value) -> Value:
    """Return ``left - right * floor(left / right)``: the remainder with the sign of the divisor.

    For the integer divisor 0 it is ``left`` if that is an integer; otherwise x % 0 is NaN.
    """
    if right == 0:
        return left if isinstance(left, int) and isinstance(right, int) else math.nan
    try:
        return left % right
    except OverflowError:  # a double, and an integer too large for one
        return widen(left) % widen(right)


def given(value: Value | None) -> Value:
    """Return the value if it is not missing.

    Raises:
        Undefined: it is None: a missing array element, or data not yet received.
    """
    if value is None:
        raise Undefined
    return value


def in_range(value: Any, low: int, high: int, what: str) -> Any:
    """Return the value if it is in its range.

    Raises:
        Mismatch: it is not; ``what`` names it in the text.
    """
    if low <= value <= high:
        return value
    raise Mismatch("%s is %r, outside %d..%d" % (what, value, low, high))


def now() -> Value:
    """Return the placeholder for the time of sending."""
    return NOW


def copied(data: Value) -> Value:
    """Return a copy of stored data, which sending may modify."""
    return copy.deepcopy(data)


def optional(part: Callable[[], Value]) -> Value | None:
    """Return a part of a message; None if an array in it is too short."""
    try:
        return part()
    except IndexError:
        return None
