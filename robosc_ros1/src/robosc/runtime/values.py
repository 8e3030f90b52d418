"""Arithmetic and undefined values, as the language means them."""

from __future__ import annotations

import math
from typing import Any, Dict, Optional

__all__ = ["Mismatch", "Undefined", "Value", "divide", "given", "in_range", "jsonable"]

Value = Any
"""A value of the language: bool, int, float or str; a dict of them by path for an object."""


class Mismatch(Exception):
    """The robot reports what the model says cannot happen now; nothing of it was applied."""


class Undefined(Exception):
    """An expression reads an array element that did not come."""


def divide(left: float, right: float) -> float:
    """IEEE 754 division: never an error, x/0 is an infinity or not a number."""
    try:
        numerator, denominator = float(left), float(right)
    except OverflowError:  # an integer beyond the doubles
        return math.nan
    if denominator != 0.0:
        return numerator / denominator
    if numerator == 0.0 or math.isnan(numerator):
        return math.nan
    return math.copysign(math.inf, numerator) * math.copysign(1.0, denominator)


def given(value: Optional[Value]) -> Value:
    """The value, if it came.

    Raises:
        Undefined: it is None, an element past the end of its array.
    """
    if value is None:
        raise Undefined
    return value


def in_range(value: Any, low: int, high: int, what: str) -> Any:
    """The value, if it lies in the range that the model gives it.

    Raises:
        Mismatch: it does not.
    """
    if low <= value <= high:
        return value
    raise Mismatch("%s is %r, outside %d..%d" % (what, value, low, high))


_NOT_FINITE = {"nan": "NaN", "inf": "Infinity", "-inf": "-Infinity"}


def jsonable(value: Value) -> Value:
    """The value for JSON, which has no spelling for infinities and NaN: they become strings."""
    if isinstance(value, float) and not math.isfinite(value):
        return _NOT_FINITE[str(value)]
    if isinstance(value, dict):
        result: Dict[str, Any] = {key: jsonable(part) for key, part in value.items()}
        return result
    return value
