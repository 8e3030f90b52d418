"""Chains over many: whatever they share, they say the same of the same parts."""

from __future__ import annotations

from collections.abc import Iterator

import pytest

from robosc.expr.quantified import Chains, chain
from robosc.expr.tree import Binary, Expr, StateRef, Unary
from robosc.model.entities import Robot
from robosc.model.resolve import load
from robosc.source import Source


def leaves(expr: Expr) -> Iterator[Expr]:
    if isinstance(expr, Binary):
        yield from leaves(expr.left)
        yield from leaves(expr.right)
    else:
        yield expr


def depth(expr: Expr) -> int:
    return 1 + max(depth(expr.left), depth(expr.right)) if isinstance(expr, Binary) else 0


@pytest.mark.parametrize("runs", [[(0, n) for n in range(301)], [(k, k + 90) for k in range(200)]])
def test_chains_over_runs_have_just_their_parts(runs: list[tuple[int, int]]) -> None:
    parts = [StateRef("Station", str(number)) for number in range(300)]
    known: Chains = {}
    for first, last in runs[1:]:
        found = chain("or", parts[first:last], known=known)
        assert list(leaves(found)) == parts[first:last]
        assert depth(found) < 80


def test_the_same_part_may_stand_several_times() -> None:
    part = StateRef("Station", "waiting")
    known: Chains = {}
    for count in (2, 5, 3):
        assert len(list(leaves(chain("or", [part] * count, known=known)))) == count


def test_chains_that_differ_in_the_middle_are_different() -> None:
    first, last, one, other = (StateRef("Station", state) for state in "abcd")
    known: Chains = {}
    for middle in (one, other):
        assert list(leaves(chain("or", [first, middle, last], known=known))) == [
            first, middle, last,
        ]  # fmt: skip


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
