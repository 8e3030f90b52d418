"""Guards as short expressions of the language.

Synthesis gives each controllable event a set of states; users want a condition. Where the
requirements alone give the same set, their expression is the guard. Otherwise the guard is found by
two-level minimisation: it is exact in every state of the controlled system in which the plant can
do the event (the care set), and unspecified elsewhere. State variables that are not needed are
dropped one after another, and what is left is written as a sum of products
(:mod:`robosc.synthesis.guards.minimise`). If the result is long, alternatives are tried, and the
shortest one is taken: a comparison of two values, a count of components (also together with a
condition on the event's own state variables), and the weakest precondition of the state
requirements, where that is exact.

Engines pass their sets as a :class:`CareSet`; nothing here depends on their representation.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import replace
from functools import cache, partial
from itertools import chain, islice
from typing import Any, Protocol

from robosc import dotted
from robosc.expr.traversal import operands, walk
from robosc.expr.tree import FALSE, TRUE, Binary, Count, Expr, Unary
from robosc.lazy_dataclasses import dataclass
from robosc.names import Copy
from robosc.plant.automaton import Event, Plant, VariableKind
from robosc.plant.counting import copies_of, with_component, with_counts
from robosc.plant.logic import conjunction, disjunction, negation
from robosc.plant.support import event_support, step_support, support
from robosc.supervisor import Guard, Status
from robosc.synthesis.guards.greedy_selection import drop
from robosc.synthesis.guards.lasting_counts import lasting_counts
from robosc.synthesis.guards.precondition import (
    lasting_precondition,
    next_precondition,
    precondition,
)
from robosc.synthesis.guards.sum_of_products import MOST_STEPS, TooLarge

_SMALL = 2**6
"""Combinations up to which a cover is computed without trying anything else before."""
_LARGE = 2**9
"""Combinations above which a cover takes longer than to try preconditions."""
_VAST = 2**16
"""Combinations above which dropping variables takes longer still, if the precondition reads more
variables than can be few combinations: robots on a grid (``robot_families``)."""
_LONG = 40
"""Length (:func:`_length`) above which a shorter guard is looked for."""
_FEW_STEPS = 2**14
"""Steps that a cover may take where a guard is known already. Robots that pass doors, with five of
them: 7 s of 11 before."""


class CareSet(Protocol):
    """States in which an event is allowed, and states in which it is refused.

    ``parts`` are the groups of state variables that are not projected away yet; a group is kept or
    projected away as a whole.
    """

    @property
    def parts(self) -> tuple[tuple[int, ...], ...]: ...

    def without(self, parts: Sequence[tuple[int, ...]]) -> CareSet | None:
        """Return the projection without some parts; None if the two sets would then overlap."""

    def within(self, allowed: Expr, refused: Expr) -> CareSet | None:
        """Return the sets, each restricted to a condition; None if that is too costly."""

    def separates(self, condition: Expr) -> bool:
        """Whether a condition holds where the event is allowed and fails where it is refused."""

    @property
    def size(self) -> int:
        """The number of combinations of values of all parts."""

    def condition(self, order: Callable[[int], Any], most_steps: int) -> Expr:
        """Return a condition that separates the sets.

        State variables that it can do without are dropped, the first by ``order`` first.

        Raises:
            TooLarge: it would be too long, or take more than ``most_steps``.
        """


@dataclass(frozen=True)
class GuardInputs:
    """What an engine computed for a controllable event, over states of the controlled system.

    ``is_never``: it is allowed in none of them; ``is_as_required``: in all of those in which the
    plant can do it and the requirements allow it. The functions return the care set whose refused
    states are among these (``within_requirement``), or among all in which the plant can do it
    (``within_plant``).
    """

    is_never: bool
    is_as_required: bool
    within_requirement: Callable[[], CareSet]
    within_plant: Callable[[], CareSet]


class GuardMaker:
    """Makes the guards of one plant.

    Whether a guard is shorter if it is made anew than if it extends the requirements is found once
    for all copies of a command whose requirements are the same but for the copy.
    """

    def __init__(self, plant: Plant) -> None:
        self._plant = plant
        self._extending: dict[object, tuple[Copy, Expr]] = {}
        """Per command of a family whose guard extends the requirements, the copy and these."""

    def guard(self, event: Event, inputs: GuardInputs) -> Guard:
        """Return the guard of a controllable event."""
        required = event.requirement or TRUE
        if inputs.is_never:
            return Guard(event, FALSE, required, "never")
        if inputs.is_as_required:
            return Guard(event, required, required, "as required")
        status: Status = "restricted"
        extra = _condition(self._plant, event, inputs.within_requirement())
        together = conjunction(operands(conjunction([required, extra]), "and"))
        if event.requirement is None or self._is_like_another(event):
            return Guard(event, together, required, status)
        try:
            fresh = _condition(self._plant, event, inputs.within_plant(), _FEW_STEPS)
        except TooLarge:
            fresh = together
        if _length(self._plant, fresh) < _length(self._plant, together):
            return Guard(event, fresh, required, status)
        if (copy := Copy.of(dotted.first(event.key))) is not None:
            self._extending.setdefault(_of_family(event, copy), (copy, required))
        return Guard(event, together, required, status)

    def _is_like_another(self, event: Event) -> bool:
        """Whether the guard of another copy extends its requirements, which are the same."""
        copy = Copy.of(dotted.first(event.key))
        known = None if copy is None else self._extending.get(_of_family(event, copy))
        if copy is None or known is None:
            return False
        names = {known[0].name: copy.name, copy.name: known[0].name}
        return with_component(known[1], lambda name: names.get(name, name)) == event.requirement


def _of_family(event: Event, copy: Copy) -> object:
    """Return what a command has in common with those of other copies."""
    return event.kind, copy.family, dotted.inside(event.key), event.index, event.path


def _condition(plant: Plant, event: Event, care_set: CareSet, most_steps: int = MOST_STEPS) -> Expr:
    """Return a short condition that separates a care set.

    Each kind of candidate has models in the tests whose guards are long without it: counts, and
    what stands beside them, lamps that fade (``test_steep_families``), preconditions its tokens,
    budgets and conveyors, comparisons those of ``test_guards``.
    """
    rank = _variable_order(plant, event)
    candidates = chain(_counts(plant, event), _comparisons(plant, event))
    conditions = list(islice(filter(care_set.separates, candidates), 1))
    if conditions and care_set.size > _SMALL:
        return conditions[0]
    demanded = cache(lambda: _demanded(plant, event, care_set))
    exact = demanded() if care_set.size > _VAST else None
    if exact is not None and _is_short(plant, exact) and 2 ** len(support(plant, exact)) > _SMALL:
        return exact
    left = _pruned(care_set, rank)
    if left.size <= _SMALL or (len(left.parts) < 3 and left.size <= _LARGE):
        conditions += _attempt(left, rank)
        if (short := _short(plant, conditions)) is not None:
            return short
    counts = _counts(plant, event, lasting=True)
    beside = [_beside(plant, event, care_set, count, rank) for count in counts]
    conditions += [one for one in beside if one is not None]
    if (short := _short(plant, conditions)) is not None:
        return short
    if (exact := demanded()) is not None:
        conditions.append(exact)
        if _is_short(plant, exact):
            return min(conditions, key=partial(_length, plant))
    if not conditions:
        lasting = _needed(lasting_precondition(plant, event), care_set)
        conditions = [] if lasting is None else [lasting]
        if (short := _short(plant, conditions)) is not None:
            return short
        conditions += _attempt(left, rank, most_steps)
    if not conditions:
        raise TooLarge(f"the guard of {event.name} would be too long")
    return min(conditions, key=partial(_length, plant))


def _counts(plant: Plant, event: Event, lasting: bool = False) -> Iterator[Expr]:
    """Yield candidate guards for an event that changes how many components are in a state.

    With ``lasting``, also for one after which uncontrollable events may change that number.
    """
    for condition in plant.tighter_counts:
        if not event.writes.isdisjoint(support(plant, condition)):
            yield condition
    for invariant, _ in plant.invariants if lasting else ():
        for condition in lasting_counts(plant, invariant):
            if not event.writes.isdisjoint(support(plant, condition)):
                yield condition


def _comparisons(plant: Plant, event: Event) -> Iterator[Expr]:
    """Yield how two values may compare that a state requirement on the event compares."""
    concerned = [
        condition
        for condition, _ in plant.invariants
        if not event.writes.isdisjoint(support(plant, condition))
    ]
    compared = dict.fromkeys(
        node
        for condition in concerned
        for node in plant.comparisons.of(condition, partial(_compared, plant))
    )
    for node in compared:
        if node.operator not in ("=", "!="):
            yield from (replace(node, operator=operator) for operator in ("<", "<=", ">", ">="))
    yield from (replace(node, operator="!=") for node in compared)


def _compared(plant: Plant, condition: Expr) -> tuple[Binary, ...]:
    """Return the comparisons in a condition of which both sides read the state."""
    found = (
        node
        for node in walk(condition)
        if isinstance(node, Binary) and node.operation.is_comparison
        if support(plant, node.left) and support(plant, node.right)
    )
    return tuple(dict.fromkeys(found))


def _beside(
    plant: Plant, event: Event, care_set: CareSet, count: Expr, rank: Callable[[int], Any]
) -> Expr | None:
    """Return a guard ``needed and (free or count)``, both over the event's own variables."""
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
    """Return the precondition of the state requirements, if exact."""
    direct = precondition(plant, event)
    if care_set.separates(direct):
        return direct
    return _needed(next_precondition(plant, event), care_set)


def _needed(parts: Sequence[Expr], care_set: CareSet) -> Expr | None:
    """Return the conjunction of some parts, without superfluous ones, if exact."""
    if not care_set.separates(conjunction(parts)):
        return None

    def without(left: Iterable[Expr], some: Sequence[Expr]) -> Iterable[Expr] | None:
        fewer = [part for part in left if part not in some]
        return fewer if care_set.separates(conjunction(fewer)) else None

    return conjunction(drop(parts, parts, without))


def _attempt(
    care_set: CareSet, rank: Callable[[int], Any], most_steps: int = MOST_STEPS
) -> list[Expr]:
    try:
        return [care_set.condition(rank, most_steps)]
    except TooLarge:
        return []


def _pruned(care_set: CareSet, rank: Callable[[int], Any]) -> CareSet:
    """Return the projection without superfluous parts, the least useful dropped first."""
    parts = sorted(care_set.parts, key=lambda part: max(rank(variable) for variable in part))
    return drop(parts, care_set, lambda left, some: left.without(some))


def _variable_order(plant: Plant, event: Event) -> Callable[[int], tuple[bool, bool, int]]:
    near = event_support(plant, event)

    def rank(variable: int) -> tuple[bool, bool, int]:
        # A phase cannot be written in a model, so among equals it is dropped first.
        return variable in near, plant.variables[variable].kind is not VariableKind.PHASE, -variable

    return rank


def _short(plant: Plant, conditions: Sequence[Expr]) -> Expr | None:
    """Return the shortest if it is not long; each length is computed once, since it takes time."""
    lengths = [_length(plant, one) for one in conditions]
    shortest = min(lengths, default=_LONG + 1)
    return None if shortest > _LONG else conditions[lengths.index(shortest)]


def _is_short(plant: Plant, expr: Expr) -> bool:
    return _length(plant, expr) <= _LONG


def _length(plant: Plant, expr: Expr) -> int:
    """Return how long a condition reads: two per leaf, one per negation."""
    nodes = list(walk(with_counts(expr, plant.robot)))
    leaves = sum(
        _of_count(node) if isinstance(node, Count) else 2
        for node in nodes
        if not hasattr(node, "operator")
    )
    return leaves + sum(1 for node in nodes if isinstance(node, Unary))


def _of_count(count: Count) -> int:
    """Return the length of a count: three leaves, and one per condition of a written list."""
    return 6 + (0 if copies_of(count) else len(count.conditions))
