"""Whether guards can hold together, found by trying the values of what they read."""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator, Mapping, Sequence
from itertools import combinations, pairwise, product
from math import prod
from typing import TypeAlias

from robosc import dotted, errors, limits
from robosc.expr import evaluation, traversal, tree, types
from robosc.expr.traversal import walk
from robosc.expr.tree import Expr, PhaseRef, StateRef, VariableRef
from robosc.language.operators import MIRRORED
from robosc.model.automata import Behaviour, Transition
from robosc.model.diagnostics import Report
from robosc.model.entities import Component
from robosc.model.typing.command_values import fold_text

_Case: TypeAlias = Mapping[tree.Leaf, types.Value]


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
    if isinstance(part, tree.Binary) and part.operator in MIRRORED:
        for one, other in ((part.left, part.right), (part.right, part.left)):
            if one == leaf and isinstance(other, tree.Literal) and other.value is not None:
                yield other.value


def _numbers(constants: Iterable[types.Value]) -> list[int | float]:
    return [c for c in constants if isinstance(c, int | float) and math.isfinite(c)]


# The check for overlapping guards in models without a state space. Whether two guards can
# hold together depends on the reachable states, so synthesis checks it. A model with errors,
# or a library, has no state space; there the guards are compared over all values of what they
# read. In a library only guards that read nothing but received values are reported, because
# its variables may never reach the other values.


def check_overlaps(components: Iterable[Component], report: Report, *, library: bool) -> None:
    """Report each pair of transitions on one event whose guards can hold together.

    ``library``: only guards that read nothing but received values.
    """
    states = {c.name: [s.name for s in c.states] for c in components}
    for component in components:
        if component.library is not None:
            continue
        for place, first, second in _pairs(component.behaviour):
            assert first.guard is not None and second.guard is not None
            here = states | {component.name: [s.name for s in component.states if s.is_in(place)]}
            guards = [first.guard, second.guard]
            if not (library and _reads_the_state(guards)) and hold_together(guards, here):
                _report(component, first, second, report)


def _pairs(
    behaviour: Behaviour,
) -> Iterator[tuple[str | None, Transition, Transition]]:
    """Pairs of guarded transitions on one event, with their state; None stands for every state."""
    places: list[tuple[str | None, tuple[Transition, ...]]]
    places = [(None, behaviour.on_communications)]
    places += [(place.name, place.on_communications) for place in behaviour.places]
    for place, transitions in places:
        guarded = [t for t in transitions if t.guard is not None]
        for first, second in combinations(guarded, 2):
            if (first.event, first.communication) == (second.event, second.communication):
                yield place, first, second


def _reads_the_state(guards: Iterable[Expr]) -> bool:
    return any(isinstance(p, VariableRef | StateRef | PhaseRef) for g in guards for p in walk(g))


def _report(component: Component, first: Transition, second: Transition, report: Report) -> None:
    guards = [fold_text(t.guard.span.text) for t in (first, second) if t.guard and t.guard.span]
    name = dotted.last(second.communication)
    report.add(
        "guard-overlap",
        second.span,
        f"the guards '{guards[0]}' and '{guards[1]}' of two transitions on"
        f" {name}.{second.event.value} of {component.name} can hold together",
        "make the guards exclude each other",
        [errors.Note("the other transition", first.span)],
    )
