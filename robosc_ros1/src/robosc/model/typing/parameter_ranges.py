"""Comparisons that the range of a parameter decides, whatever its value is."""

from __future__ import annotations

from collections.abc import Callable, Mapping

from robosc.expr import evaluation, tree

_MIRRORED = {"<": ">", "<=": ">=", ">": "<", ">=": "<=", "=": "=", "!=": "!="}
_ALWAYS: Mapping[str, Callable[[float, float, float], bool]] = {
    "<": lambda low, high, limit: high < limit,
    "<=": lambda low, high, limit: high <= limit,
    ">": lambda low, high, limit: low > limit,
    ">=": lambda low, high, limit: low >= limit,
    "=": lambda low, high, limit: low == high == limit,
    "!=": lambda low, high, limit: not low <= limit <= high,
}
_OPPOSITE = {"<": ">=", "<=": ">", ">": "<=", ">=": "<", "=": "!=", "!=": "="}


def decided(comparison: tree.Binary) -> tree.Expr:
    """Return ``far > 3.0`` as what it is for every value that the parameter can have."""
    operator, left, right = comparison.operator, comparison.left, comparison.right
    if operator not in _ALWAYS:
        return comparison
    if isinstance(right, tree.ParameterRef):
        operator, left, right = _MIRRORED[operator], right, left
    if not isinstance(left, tree.ParameterRef) or left.parameter.bounds is None:
        return comparison
    limit = evaluation.constant(right)
    if isinstance(limit, bool) or not isinstance(limit, int | float):
        return comparison
    low, high = left.parameter.bounds
    for value, word in ((True, operator), (False, _OPPOSITE[operator])):
        if _ALWAYS[word](low, high, limit):
            return tree.Literal(value, comparison.type, comparison.span)
    return comparison
