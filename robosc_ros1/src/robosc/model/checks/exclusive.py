"""Whether guards can hold together, found by trying the values of what they read."""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator, Mapping, Sequence
from itertools import pairwise, product
from math import prod
from typing import TypeAlias

from robosc import limits
from robosc.expr import evaluation, traversal, tree, types

_Case: TypeAlias = Mapping[tree.Leaf, types.Value]
_COMPARING = ("=", "!=", "<", "<=", ">", ">=")


def hold_together(guards: Sequence[tree.Expr], states: Mapping[str, Sequence[str]]) -> bool | None:
    """Whether there are values with which all guards hold; None: unknown, too much would be tried.

    ``states`` are those of each component. A number or a string that is compared with nothing but
    constants has a value for each way in which the comparisons can turn out.
    """
    leaves = {
        part: None
        for guard in guards
        for part in traversal.walk(guard)
        if isinstance(
            part,
            tree.VariableRef | tree.ValueRef | tree.StateRef | tree.PhaseRef | tree.ParameterRef,
        )
    }
    choices = _choices(leaves, states, guards)
    if choices is None or prod(map(len, choices)) > limits.OVERLAP_CASES:
        return None
    for parts in product(*choices):
        case = {leaf: value for part in parts for leaf, value in part.items()}
        if all(evaluation.evaluate(guard, case.__getitem__) is True for guard in guards):
            return True
    return False


def _choices(
    leaves: Iterable[tree.Leaf], states: Mapping[str, Sequence[str]], guards: Sequence[tree.Expr]
) -> list[Sequence[_Case]] | None:
    """Independent sets of values of the leaves; None if one is infinite.

    The leaves that ask for states of one component vary together: it is in one of its states. So
    do those that ask for phases of one communication: it is in one of them, or in another.
    """
    choices: list[Sequence[_Case]] = []
    in_states: dict[str, list[tree.StateRef]] = {}
    in_phases: dict[str, list[tree.PhaseRef]] = {}
    for leaf in leaves:
        if isinstance(leaf, tree.StateRef):
            in_states.setdefault(leaf.component, []).append(leaf)
            continue
        if isinstance(leaf, tree.PhaseRef):
            in_phases.setdefault(leaf.communication, []).append(leaf)
            continue
        values = types.domain(leaf.type)
        if values is None or values[: limits.OVERLAP_CASES] != values:
            values = _telling(leaf, guards)
        if values is None:
            return None
        choices.append([{leaf: value} for value in values])
    for component, asked in in_states.items():
        choices.append([{ref: s in ref.places for ref in asked} for s in states.get(component, ())])
    for refs in in_phases.values():
        phases = dict.fromkeys(phase for ref in refs for phase in ref.places)
        choices.append([{ref: p in ref.places for ref in refs} for p in (*phases, None)])
    return choices


def _telling(leaf: tree.Leaf, guards: Sequence[tree.Expr]) -> list[types.Value] | None:
    """Values of a number or a string between which no guard tells more; None if it does other than
    compare it with constants."""
    parts = [part for guard in guards for part in traversal.walk(guard)]
    constants = [c for part in parts for c in _compared(part, leaf)]
    if len(constants) < sum(part == leaf for part in parts):
        return None
    match leaf.type:
        case types.StringType():
            texts = [c for c in constants if isinstance(c, str)]
            return [*dict.fromkeys(texts), "".join(texts) + "?"]
        case types.IntegerType(bounds=bounds):
            low, high = bounds or (-math.inf, math.inf)
            near = {math.floor(c) + d for c in _numbers(constants) for d in (-1, 0, 1, 2)}
            return [value for value in sorted(near) if low <= value <= high]
        case types.DoubleType():
            ends = sorted({*_numbers(constants)})
            between = [a + (b - a) / 2 for a, b in pairwise(ends)]
            return [*ends, *between, -math.inf, math.inf, math.nan]
    return None


def _compared(part: tree.Expr, leaf: tree.Leaf) -> Iterator[types.Value]:
    """The constant with which a comparison compares the leaf."""
    if isinstance(part, tree.Binary) and part.operator in _COMPARING:
        for one, other in ((part.left, part.right), (part.right, part.left)):
            if one == leaf and isinstance(other, tree.Literal) and other.value is not None:
                yield other.value


def _numbers(constants: Iterable[types.Value]) -> list[int | float]:
    return [c for c in constants if isinstance(c, int | float) and math.isfinite(c)]
