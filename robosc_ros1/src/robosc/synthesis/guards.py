"""Guards as short expressions of the language.

Synthesis gives each controllable event a set of states; users want a condition. Where the
requirements alone give the same set, their own wording is the guard. Otherwise an expression is
made that is right in every state of the controlled system in which the plant can do the event, and
means nothing elsewhere: the state variables that do not matter are dropped one after another, and
what the rest distinguishes is covered by few and wide boxes (:mod:`robosc.synthesis.minimise`). If
that is long, other ways are tried, and the shortest result is taken: a count of components and what
the event's own state must be, what the state requirements demand of the state after the event,
where that happens to be the guard, and state variables selected one after another by how much they
distinguish.

Engines hand in their sets as a :class:`CareSet`; nothing here depends on their representation.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import dataclass
from typing import Any, Protocol

from robosc.ir.automaton import Event, Plant, VariableKind
from robosc.ir.counting import copies_of, with_counts
from robosc.ir.formulas import conjunction, disjunction, negation
from robosc.model.expr import FALSE, TRUE, Count, Expr, Unary
from robosc.model.traversal import walk
from robosc.supervisor import Guard, Status
from robosc.synthesis.dropping import drop
from robosc.synthesis.lasting_counts import lasting_counts, step_support
from robosc.synthesis.precondition import next_precondition, precondition
from robosc.synthesis.sum_of_products import TooLarge
from robosc.synthesis.vectorised import support

__all__ = ["CareSet", "GuardInputs", "make_guard"]

_SMALL = 2**6
"""Up to this many combinations a cover is found at once."""
_LARGE = 2**9
"""From here on a cover takes longer than to look for the guard in the requirements' own words."""
_LONG = 40
"""Guards with more to read than this are worth looking for shorter ones."""


class CareSet(Protocol):
    """States in which an event is allowed, and states in which it is refused.

    ``parts`` are the groups of state variables that still distinguish states, each to be kept or
    forgotten as a whole.
    """

    @property
    def parts(self) -> tuple[tuple[int, ...], ...]: ...

    def without(self, parts: Sequence[tuple[int, ...]]) -> CareSet | None:
        """The same with some parts forgotten; None if the two sets would then overlap."""

    def selected(self) -> CareSet | None:
        """The same with parts selected by how much they distinguish; None if that is too costly."""

    def within(self, allowed: Expr, refused: Expr) -> CareSet | None:
        """The allowed and the refused states in which conditions hold; None if too costly."""

    def separates(self, condition: Expr) -> bool:
        """Whether a condition holds where the event is allowed and fails where it is refused."""

    @property
    def size(self) -> int:
        """The combinations of values of all parts."""

    def condition(self, order: Callable[[int], Any]) -> Expr:
        """A condition that separates the sets; of state variables, the first in the order are
        dropped first.

        Raises:
            TooLarge: it would be too long.
        """


@dataclass(frozen=True)
class GuardInputs:
    """What an engine knows of a controllable event, of states of the controlled system alone.

    ``required`` is how many states allow it in the plant under requirements, ``enabled`` in how
    many of them it is allowed under control. The functions give the refused states among those in
    which requirements allow it, and among all those in which the plant can do it.
    """

    required: int
    enabled: int
    within_requirement: Callable[[], CareSet]
    within_plant: Callable[[], CareSet]


def make_guard(plant: Plant, event: Event, inputs: GuardInputs) -> Guard:
    """The guard of a controllable event."""
    required = TRUE if event.requirement is None else event.requirement
    if inputs.enabled == 0:
        return Guard(event, FALSE, required, "never")
    if inputs.enabled == inputs.required:
        return Guard(event, required, required, "as required")
    status: Status = "restricted"
    extra = _condition(plant, event, inputs.within_requirement())
    together = conjunction([required, extra])
    if event.requirement is None:
        return Guard(event, together, required, status)
    fresh = _condition(plant, event, inputs.within_plant())
    shorter = fresh if _length(fresh) < _length(together) else together
    return Guard(event, shorter, required, status)


def _condition(plant: Plant, event: Event, care_set: CareSet) -> Expr:
    rank = _variable_order(plant, event)
    found = [count for count in _counts(plant, event) if care_set.separates(count)][:1]
    if found and care_set.size > _SMALL:
        return found[0]
    left = _pruned(care_set, rank)
    if left.size <= _SMALL or (len(left.parts) < 3 and left.size <= _LARGE):
        found += _attempt(left, rank)
        if (short := _short(found)) is not None:
            return short
    counts = _counts(plant, event, lasting=True)
    beside = [_beside(plant, event, care_set, count, rank) for count in counts]
    found += [one for one in beside if one is not None]
    if (short := _short(found)) is not None:
        return short
    demanded = _demanded(plant, event, care_set)
    if demanded is not None:
        found.append(demanded)
        if _length(demanded) <= _LONG:
            return min(found, key=_length)
    if not found:
        found = _attempt(left, rank)
    if all(_length(one) > _LONG for one in found):
        selected = care_set.selected()
        if selected is not None:
            found.extend(_attempt(_pruned(selected, rank), rank))
    if not found:
        raise TooLarge(f"the guard of {event.name} would be too long")
    return min(found, key=_length)


def _counts(plant: Plant, event: Event, lasting: bool = False) -> Iterator[Expr]:
    """What may be the guard of an event that changes how many components are in a state.

    With ``lasting``, also of one after which uncontrollable events may change it.
    """
    written = plant.writes[plant.number(event)]
    for condition in plant.tighter_counts:
        if not written.isdisjoint(support(plant, condition)):
            yield condition
    for invariant, _ in plant.invariants if lasting else ():
        for condition in lasting_counts(plant, invariant):
            if not written.isdisjoint(support(plant, condition)):
                yield condition


def _beside(
    plant: Plant, event: Event, care_set: CareSet, count: Expr, rank: Callable[[int], Any]
) -> Expr | None:
    """A guard ``needed and (free or count)``, where the event's own state tells the first two."""
    near = step_support(plant, event)
    others = [part for part in care_set.parts if near.isdisjoint(part)]

    def own(allowed: Expr, refused: Expr) -> Expr | None:
        within = care_set.within(allowed, refused)
        left = None if within is None else within.without(others)
        if left is None or left.size > _LARGE:
            return None
        return next(iter(_attempt(_pruned(left, rank), rank)), None)

    needed = own(TRUE, count)
    if needed is None:
        return None
    full = negation(count)
    free = own(full, conjunction([needed, full]))
    return None if free is None else conjunction([needed, disjunction([free, count])])


def _demanded(plant: Plant, event: Event, care_set: CareSet) -> Expr | None:
    """What state requirements demand before the event, if that is the guard."""
    direct = precondition(plant, event)
    if care_set.separates(direct):
        return direct
    parts = next_precondition(plant, event)
    if not care_set.separates(conjunction(parts)):
        return None

    def without(left: Iterable[Expr], some: Sequence[Expr]) -> Iterable[Expr] | None:
        fewer = [part for part in left if part not in some]
        return fewer if care_set.separates(conjunction(fewer)) else None

    return conjunction(drop(parts, parts, without))


def _attempt(care_set: CareSet, rank: Callable[[int], Any]) -> list[Expr]:
    try:
        return [care_set.condition(rank)]
    except TooLarge:
        return []


def _pruned(care_set: CareSet, rank: Callable[[int], Any]) -> CareSet:
    """Without the parts that need not be looked at, the least useful ones dropped first."""
    parts = sorted(care_set.parts, key=lambda part: max(rank(variable) for variable in part))
    return drop(parts, care_set, lambda left, some: left.without(some))


def _variable_order(plant: Plant, event: Event) -> Callable[[int], tuple[bool, bool, int]]:
    near = _touched(plant, event)

    def rank(variable: int) -> tuple[bool, bool, int]:
        # Users cannot write a phase, so it is the first to go among equals.
        return variable in near, plant.variables[variable].kind is not VariableKind.PHASE, -variable

    return rank


def _touched(plant: Plant, event: Event) -> set[int]:
    """The state variables that an event's automata or its requirement read or write."""
    required = () if event.requirement is None else support(plant, event.requirement)
    return step_support(plant, event).union(required)


def _short(found: Sequence[Expr]) -> Expr | None:
    """The shortest, if it is not long; lengths of conditions with many cases take time."""
    lengths = [*map(_length, found)]
    shortest = min(lengths, default=_LONG + 1)
    return None if shortest > _LONG else found[lengths.index(shortest)]


def _length(expr: Expr) -> int:
    """How much there is to read: leaves, and a little for each negation."""
    nodes = list(walk(with_counts(expr)))
    leaves = sum(
        _of_count(node) if isinstance(node, Count) else 2
        for node in nodes
        if not hasattr(node, "operator")
    )
    return leaves + sum(1 for node in nodes if isinstance(node, Unary))


def _of_count(count: Count) -> int:
    """As much as of three conditions; that of a list also has its elements, which are alike."""
    return 6 + (0 if copies_of(count) else len(count.conditions))
