"""Expansion of aggregates: long chains of one operator, and bounds on the number that holds."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from functools import partial
from typing import Generic, TypeAlias, TypeVar

from robosc.source import Span
from robosc.syntax.nodes import BinaryNode, ExprNode, LiteralNode, UnaryNode

__all__ = ["MOST_NODES", "Cases", "Chains", "at_least", "compared", "halves", "joined"]

_Node = TypeVar("_Node")

MOST_NODES = 20_000
"""The greatest number of nodes to which a count is expanded."""

_CHAIN = 64
"""Chains up to this length are left-associative; longer trees of that form would be too high."""


Chains: TypeAlias = dict[tuple[str, int, int, int], ExprNode]
"""Chains over runs of the same parts, by operator, identities of the first and last, and length."""


def halves(parts: Sequence[_Node]) -> tuple[Sequence[_Node], Sequence[_Node]]:
    """The parts of the left and the right operand of a chain."""
    cut = len(parts) - 1
    if cut >= _CHAIN:
        cut = 1 << (cut.bit_length() - 1)  # at a power of two, which runs can share
    return parts[:cut], parts[cut:]


def joined(
    operator: str,
    parts: Sequence[ExprNode],
    span: Span,
    empty: bool | int,
    known: Chains | None = None,
) -> ExprNode:
    """The parts with an associative operator between them; ``empty`` if there are none.

    With ``known``, chains over several runs of the same parts (all stations before the third, the
    fourth, …) share subtrees.
    """
    if len(parts) < 2:
        return parts[0] if parts else LiteralNode(empty, span=span)
    key = operator, id(parts[0]), id(parts[-1]), len(parts)
    if known is not None and key in known:
        return known[key]
    left, right = (joined(operator, side, span, empty, known) for side in halves(parts))
    found = BinaryNode(operator, left, right, operator_span=span, span=span)
    if known is not None:
        known[key] = found
    return found


def at_least(operator: str, parts: Sequence[ExprNode], number: int, span: Span) -> ExprNode | None:
    """The condition that the number of conditions that hold compares so with ``number``.

    None if it needs too large an expression.
    """

    def negated(node: ExprNode) -> ExprNode:
        if isinstance(node, LiteralNode):
            return LiteralNode(not node.value, span=span)
        return UnaryNode("!", node, span=span)

    cases = Cases[ExprNode](
        lambda operator, parts: joined(operator, parts, span, empty=operator == "and"),
        (LiteralNode(False, span=span), LiteralNode(True, span=span)),
    )
    found = compared(operator, number, partial(cases.least, parts), cases.both, negated)
    return None if cases.nodes > MOST_NODES else found


def compared(
    operator: str,
    number: int,
    least: Callable[[int], _Node],
    both: Callable[[_Node, _Node], _Node],
    negated: Callable[[_Node], _Node],
) -> _Node:
    """A comparison of a count with a number, from ``least``: the condition that so many hold."""
    match operator:
        case ">=":
            return least(number)
        case ">":
            return least(number + 1)
        case "<":
            return negated(least(number))
        case "<=":
            return negated(least(number + 1))
    exactly = both(least(number), negated(least(number + 1)))
    return exactly if operator == "=" else negated(exactly)


class Cases(Generic[_Node]):
    """Expands counts: halves the conditions, and splits the number in all ways.

    ``chain`` joins conditions by an operator; ``constants`` are the nodes for false and true.
    ``nodes`` counts the nodes that were made.
    """

    def __init__(
        self, chain: Callable[[str, Sequence[_Node]], _Node], constants: tuple[_Node, _Node]
    ) -> None:
        self._chain = chain
        self._false, self._true = constants
        self.nodes = 0

    def least(self, parts: Sequence[_Node], number: int) -> _Node:
        """The condition that at least ``number`` of the conditions hold."""
        if number <= 0:
            return self._true
        if number > len(parts) or self.nodes > MOST_NODES:
            return self._false
        if number in (1, len(parts)):
            self.nodes += len(parts)
            return self._chain("or" if number == 1 else "and", parts)
        half = len(parts) // 2
        left, right = parts[:half], parts[half:]
        ways = [
            self.both(self.least(left, first), self.least(right, number - first))
            for first in range(max(0, number - len(right)), min(number, len(left)) + 1)
        ]
        return self._chain("or", ways)

    def both(self, left: _Node, right: _Node) -> _Node:
        """The conjunction of two conditions, simplified for constants."""
        for one, other in ((left, right), (right, left)):
            if one == self._true:
                return other
            if one == self._false:
                return one
        self.nodes += 1
        return self._chain("and", (left, right))
