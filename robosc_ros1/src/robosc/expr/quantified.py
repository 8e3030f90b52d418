"""Expansion of aggregates over lists: chains of one operator, bounds on how many hold."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import TypeAlias

from robosc import limits
from robosc.expr.tree import FALSE, TRUE, Binary, Expr, Literal, Unary
from robosc.expr.types import BooleanType
from robosc.source import Span

_CHAIN = 64
"""Chains up to this length are left-associative; longer trees of that form would be too high."""

_BOOLEAN = BooleanType()

Chains: TypeAlias = dict[tuple[int, ...], Expr]
"""Chains of one operator by the identities of their parts."""


def joined(
    parts: Sequence[Expr], join: Callable[[Expr, Expr], Expr], known: Chains | None = None
) -> Expr:
    """The parts, at least one, with an associative operation between them.

    With ``known``, chains over several runs of the same parts (all stations before the third, the
    fourth, …) share subtrees.
    """
    if len(parts) == 1:
        return parts[0]
    key = tuple(map(id, parts)) if known is not None else ()
    if known is not None and key in known:
        return known[key]
    cut = len(parts) - 1
    if cut >= _CHAIN:
        cut = 1 << (cut.bit_length() - 1)  # at a power of two, which runs can share
    found = join(joined(parts[:cut], join, known), joined(parts[cut:], join, known))
    if known is not None:
        known[key] = found
    return found


def chain(
    operator: str, parts: Sequence[Expr], span: Span | None = None, known: Chains | None = None
) -> Expr:
    """The conditions joined by ``and`` or ``or``; its neutral element if there are none."""
    if not parts:
        return TRUE if operator == "and" else FALSE
    return joined(parts, lambda left, right: Binary(operator, left, right, _BOOLEAN, span), known)


def opposite(condition: Expr) -> Expr:
    """``!condition``, without double negation."""
    match condition:
        case Literal(value=bool(value)):
            return FALSE if value else TRUE
        case Unary(operator="!", operand=operand):
            return operand
    return Unary("!", condition, BooleanType())


def at_least(conditions: Sequence[Expr], number: int) -> Expr | None:
    """The condition that at least ``number`` of the conditions hold; None if it is too large."""
    return compared(conditions, ">=", number)


def compared(conditions: Sequence[Expr], operator: str, number: int) -> Expr | None:
    """The condition that the number of conditions that hold compares so with ``number``.

    None if it is too large.
    """
    cases = _Cases(conditions)
    least = cases.least
    match operator:
        case ">=":
            found = least(number)
        case ">":
            found = least(number + 1)
        case "<":
            found = opposite(least(number))
        case "<=":
            found = opposite(least(number + 1))
        case _:
            exactly = cases.both(least(number), opposite(least(number + 1)))
            found = exactly if operator == "=" else opposite(exactly)
    return None if cases.nodes > limits.COUNT_NODES else found


class _Cases:
    """Expands counts of some conditions: halves them, and splits the number in all ways.

    What several cases have in common is one object. ``nodes`` counts the nodes that were made, as
    often as they are written.
    """

    def __init__(self, conditions: Sequence[Expr]) -> None:
        self._conditions = conditions
        self._known: dict[tuple[int, int, int], tuple[Expr, int]] = {}
        self.nodes = 0

    def least(self, number: int) -> Expr:
        """The condition that at least ``number`` of the conditions hold."""
        return self._least(0, len(self._conditions), number)

    def _least(self, start: int, end: int, number: int) -> Expr:
        """The same of the conditions between two places."""
        if number <= 0:
            return TRUE
        if number > end - start or self.nodes > limits.COUNT_NODES:
            return FALSE
        key = start, end, number
        if key in self._known:
            found, nodes = self._known[key]
            self.nodes += nodes
            return found
        before = self.nodes
        found = self._cases(start, end, number)
        self._known[key] = found, self.nodes - before
        return found

    def _cases(self, start: int, end: int, number: int) -> Expr:
        if number in (1, end - start):
            self.nodes += end - start
            return chain("or" if number == 1 else "and", self._conditions[start:end])
        middle = start + (end - start) // 2
        ways = [
            self.both(self._least(start, middle, first), self._least(middle, end, number - first))
            for first in range(max(0, number - (end - middle)), min(number, middle - start) + 1)
        ]
        return chain("or", ways)

    def both(self, left: Expr, right: Expr) -> Expr:
        """The conjunction of two conditions, simplified for constants."""
        for one, other in ((left, right), (right, left)):
            if one == TRUE:
                return other
            if one == FALSE:
                return one
        self.nodes += 1
        return chain("and", (left, right))
