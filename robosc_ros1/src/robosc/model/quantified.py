"""Conditions over many: long chains as balanced trees, and how many of some conditions hold."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TypeAlias

from robosc.source import Span
from robosc.syntax.nodes import BinaryNode, ExprNode, LiteralNode, UnaryNode

__all__ = ["Chains", "at_least", "joined"]

_MOST_NODES = 20_000

_CHAIN = 64
"""Chains up to this length are left-associative; longer ones would be too deep."""


Chains: TypeAlias = dict[tuple[str, int, int, int], ExprNode]
"""Chains over runs of the same parts, by operator, identities of the first and last, and length."""


def joined(
    operator: str,
    parts: Sequence[ExprNode],
    span: Span,
    empty: bool | int,
    known: Chains | None = None,
) -> ExprNode:
    """The parts with an associative operator between them; ``empty`` if there are none.

    With ``known``, chains over several runs of the same parts (all stations before the third, the
    fourth, …) have in common what can be.
    """
    if len(parts) < 2:
        return parts[0] if parts else LiteralNode(empty, span=span)
    key = operator, id(parts[0]), id(parts[-1]), len(parts)
    if known is not None and key in known:
        return known[key]
    cut = len(parts) - 1
    if cut >= _CHAIN:
        cut = 1 << (cut.bit_length() - 1)  # not in halves, which no two runs have in common
    left = joined(operator, parts[:cut], span, empty, known)
    right = joined(operator, parts[cut:], span, empty, known)
    found = BinaryNode(operator, left, right, operator_span=span, span=span)
    if known is not None:
        known[key] = found
    return found


def at_least(operator: str, parts: Sequence[ExprNode], number: int, span: Span) -> ExprNode | None:
    """Whether as many of the conditions hold as a comparison with a number says.

    None if that needs too large an expression.
    """
    cases = _Cases(span)
    match operator:
        case ">=":
            found = cases.least(parts, number)
        case ">":
            found = cases.least(parts, number + 1)
        case "<":
            found = cases.negated(cases.least(parts, number))
        case "<=":
            found = cases.negated(cases.least(parts, number + 1))
        case _:
            least, more = cases.least(parts, number), cases.least(parts, number + 1)
            found = cases.both(least, cases.negated(more))
            if operator == "!=":
                found = cases.negated(found)
    return None if cases.nodes > _MOST_NODES else found


class _Cases:
    """Splits the conditions in two halves, and the number in all ways; counts the nodes made."""

    def __init__(self, span: Span) -> None:
        self._span = span
        self.nodes = 0

    def least(self, parts: Sequence[ExprNode], number: int) -> ExprNode:
        """Whether at least ``number`` of the conditions hold."""
        if number <= 0:
            return LiteralNode(True, span=self._span)
        if number > len(parts) or self.nodes > _MOST_NODES:
            return LiteralNode(False, span=self._span)
        if number == 1:
            self.nodes += len(parts)
            return joined("or", parts, self._span, empty=False)
        if number == len(parts):
            self.nodes += len(parts)
            return joined("and", parts, self._span, empty=True)
        half = len(parts) // 2
        left, right = parts[:half], parts[half:]
        ways = [
            self.both(self.least(left, first), self.least(right, number - first))
            for first in range(max(0, number - len(right)), min(number, len(left)) + 1)
        ]
        return joined("or", ways, self._span, empty=False)

    def both(self, left: ExprNode, right: ExprNode) -> ExprNode:
        for one, other in ((left, right), (right, left)):
            if isinstance(one, LiteralNode):
                return other if one.value else one
        self.nodes += 1
        return BinaryNode("and", left, right, operator_span=self._span, span=self._span)

    def negated(self, node: ExprNode) -> ExprNode:
        if isinstance(node, LiteralNode):
            return LiteralNode(not node.value, span=self._span)
        return UnaryNode("!", node, span=self._span)
