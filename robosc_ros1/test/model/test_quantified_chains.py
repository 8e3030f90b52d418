"""Chains over many: whatever they share, they say the same of the same parts."""

from __future__ import annotations

from collections.abc import Iterator

import pytest

from robosc.model.entities import Robot
from robosc.model.expr import Binary, Expr, StateRef, Unary
from robosc.model.quantified import Chains, joined
from robosc.model.resolve import load
from robosc.source import Source, Span
from robosc.syntax.nodes import BinaryNode, ExprNode, LiteralNode

SPAN = Span(Source("chain.rscd", "any"), 0, 3)


def leaves(node: ExprNode) -> Iterator[ExprNode]:
    if isinstance(node, BinaryNode):
        yield from leaves(node.left)
        yield from leaves(node.right)
    else:
        yield node


def depth(node: ExprNode) -> int:
    return 1 + max(depth(node.left), depth(node.right)) if isinstance(node, BinaryNode) else 0


@pytest.mark.parametrize("runs", [[(0, n) for n in range(301)], [(k, k + 90) for k in range(200)]])
def test_chains_over_runs_have_just_their_parts(runs: list[tuple[int, int]]) -> None:
    parts = [LiteralNode(number, span=SPAN) for number in range(300)]
    known: Chains = {}
    for first, last in runs[1:]:
        found = joined("or", parts[first:last], SPAN, False, known)
        assert list(leaves(found)) == parts[first:last]
        assert depth(found) < 80


def test_the_same_part_may_stand_several_times() -> None:
    part = LiteralNode(1, span=SPAN)
    known: Chains = {}
    for count in (2, 5, 3):
        assert len(list(leaves(joined("+", [part] * count, SPAN, 0, known)))) == count


LINE = """
robot Line {{
    component Station[1..{count}] {{
        outgoing message button with type: none
        incoming message serve with type: none
        behaviour {{
            initial marked state idle {{ on response from button goto waiting }}
            marked state waiting {{ on request to serve goto idle }}
        }}
    }}
    for i in 2..{count} {{
        requirement Station[i].serve needs !any(s.waiting for s in Station[1..i-1])
    }}
}}
"""


def line(count: int) -> Robot:
    robot, diagnostics = load(Source("line.rscd", LINE.format(count=count)))
    assert robot is not None, diagnostics
    return robot


def parts_of(expr: Expr, seen: dict[int, Expr]) -> None:
    if id(expr) not in seen:
        seen[id(expr)] = expr
        for operand in expr.operands if isinstance(expr, Binary) else ():
            parts_of(operand, seen)


def test_conditions_of_copies_share_what_they_have_in_common() -> None:
    """All of them together grow with the number of copies, not with its square."""
    sizes = {}
    for count in (100, 200):
        seen: dict[int, Expr] = {}
        for number, requirement in enumerate(line(count).requirements, 1):
            assert isinstance(requirement.condition, Unary)
            last = requirement.condition.operand
            parts_of(last, seen)
            while isinstance(last, Binary):
                last = last.right
            assert isinstance(last, StateRef)
            assert last.component == f"Station[{number}]"
        sizes[count] = len(seen)
    assert sizes[200] < 2.5 * sizes[100]
