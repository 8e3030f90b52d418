"""Short conditions for a set of combinations of values, by a greedy two-level cover.

Two-level minimisation over state variables of several values: a *box* is a set of values per state
variable. Boxes are grown from single combinations as far as nothing refused gets in, then chosen
until all that is allowed is covered (a disjunction), or all that is refused (a conjunction of
negated boxes); the shorter of the two is taken. Compare Rudell & Sangiovanni-Vincentelli,
"Multiple-valued minimization for PLA optimization", IEEE Trans. CAD 6(5), 1987.
"""

from __future__ import annotations

from collections.abc import Callable, Collection, Iterable, Sequence
from contextlib import suppress
from dataclasses import dataclass
from functools import cache
from typing import Any, TypeAlias, TypeVar

import numpy as np

from robosc.ir.automaton import Plant, StateVariable, VariableKind
from robosc.ir.finite.cases import has_value
from robosc.ir.finite.classes import Classes, intervals
from robosc.ir.formulas import conjunction, disjunction, negation
from robosc.model.expr import (
    FALSE,
    TRUE,
    Binary,
    Expr,
    Literal,
    PhaseRef,
    StateRef,
    TestRef,
    Unary,
    VariableRef,
)
from robosc.model.traversal import walk
from robosc.model.types import BooleanType, IntegerType
from robosc.synthesis.sum_of_products import Diagrams, Product, TooLarge, full_mask
from robosc.synthesis.vectorised import Bools, Indexes

__all__ = ["LARGEST_TABLE", "Table", "condition_of", "condition_of_products", "condition_on"]

_BOOLEAN = BooleanType()
_Reference: TypeAlias = VariableRef | TestRef
_Set = TypeVar("_Set")
_Box: TypeAlias = list[Bools]
"""Per state variable, which values are in the box."""

LARGEST_TABLE = 2**10
"""Combinations above which a greedy cover takes too long: each box looks at all of them."""
_MOST_BOXES = 32
"""Boxes above which an irredundant sum of products is found faster and is no longer."""


@dataclass(frozen=True, eq=False)
class Table:
    """Two disjoint sets of combinations: boolean arrays with one dimension per state variable."""

    variables: tuple[int, ...]
    allowed: Bools
    refused: Bools

    def reduced(self, order: Callable[[int], Any]) -> Table:
        """Return the projection without superfluous state variables, dropped in that order."""
        table = self
        for variable in sorted(self.variables, key=order):
            table = table._without(variable) or table
        return table

    def _without(self, variable: int) -> Table | None:
        place = self.variables.index(variable)
        allowed, refused = self.allowed.any(axis=place), self.refused.any(axis=place)
        if (allowed & refused).any():
            return None
        return Table(self.variables[:place] + self.variables[place + 1 :], allowed, refused)


def condition_of(plant: Plant, table: Table) -> Expr:
    """Return an expression that holds in what is allowed and fails in what is refused."""
    if not table.allowed.any():
        return FALSE
    if not table.refused.any():
        return TRUE
    sets = table.allowed, table.refused
    found = _shortest(plant, table.variables, sets, _cover)
    if found is not None:
        return found
    diagrams = Diagrams(table.allowed.shape)
    allowed, refused = (diagrams.of_rows(np.argwhere(each)) for each in sets)
    return condition_of_products(plant, table.variables, diagrams, allowed, refused)


def condition_on(plant: Plant, variable: int, indexes: Collection[int]) -> Expr:
    """Return an expression that a state variable has a value with one of some indexes."""
    inside = np.isin(np.arange(plant.variables[variable].size), list(indexes))
    return condition_of(plant, Table((variable,), inside, ~inside))


def condition_of_products(
    plant: Plant, variables: Sequence[int], diagrams: Diagrams, allowed: int, refused: int
) -> Expr:
    """Return the same for two sets over many state variables, given as decision diagrams.

    Raises:
        TooLarge: neither set has a sum of products of a reasonable length.
    """

    def products(inside: int, outside: int) -> Sequence[Product]:
        return diagrams.products(inside, diagrams.complement(outside))

    found = _shortest(plant, variables, (allowed, refused), products)
    if found is None:
        raise TooLarge("a guard would be too long")
    return found


def _shortest(
    plant: Plant,
    variables: Sequence[int],
    sets: tuple[_Set, _Set],
    cover: Callable[[_Set, _Set], Sequence[Product]],
) -> Expr | None:
    """Return the shorter condition: in a cover of the first set, or not in one of the second.

    None if both covers are too large.
    """
    found: list[Expr] = []
    for inside, outside, positive in ((*sets, True), (*sets[::-1], False)):
        with suppress(TooLarge):
            found.append(_joined(plant, variables, cover(inside, outside), positive))
    return min(found, key=_cost, default=None)


def _joined(
    plant: Plant, variables: Sequence[int], boxes: Iterable[Product], positive: bool
) -> Expr:
    """Return the condition of being in some box, or in none if not ``positive``."""

    @cache
    def literal(variable: int, needed: int, free: int) -> Expr:
        return _literal(plant, plant.variables[variable], needed, free)

    def literals(box: Product) -> Iterable[Expr]:
        """Yield the condition on each state variable of the box, or of its negation."""
        for variable, (needed, free) in zip(variables, box, strict=True):
            full = full_mask(plant.variables[variable].size)
            if free != full:
                low, high = (needed, free) if positive else (full - free, full - needed)
                yield literal(variable, low, high)

    if positive:
        return disjunction(conjunction(literals(box)) for box in boxes)
    return conjunction(disjunction(literals(box)) for box in boxes)


def _cost(expr: Expr) -> tuple[int, int]:
    leaves = negations = 0
    for node in walk(expr):
        if isinstance(node, Unary):
            negations += 1
        elif not isinstance(node, Binary | Literal):
            leaves += 1
    return leaves, negations


# --- boxes ---------------------------------------------------------------------------------------


def _cover(inside: Bools, outside: Bools) -> list[Product]:
    """Return boxes that contain all of ``inside`` and nothing of ``outside``."""
    refused = np.argwhere(outside)
    orders = _orders(inside.ndim)
    left = inside.copy()
    boxes: list[_Box] = []
    while left.any():
        seed = np.unravel_index(int(np.argmax(left)), left.shape)
        grown = _grown(np.array(seed), refused, left.shape, orders)
        box = _best(grown, np.argwhere(left))
        boxes.append(box)
        if len(boxes) > _MOST_BOXES:
            raise TooLarge("a cover takes too many boxes")
        left[np.ix_(*box)] = False
    return _irredundant(inside, boxes)


def _orders(count: int) -> Indexes:
    """Return orders in which to grow a box: every rotation of the variables, in both directions."""
    forward = list(range(count))
    found = []
    for start in range(count):
        turned = forward[start:] + forward[:start]
        found += [turned, turned[:1] + turned[:0:-1]]
    return np.array(found)


def _grown(seed: Indexes, refused: Indexes, shape: tuple[int, ...], orders: Indexes) -> list[Bools]:
    """Return maximal boxes around one combination, one per order, free of refused combinations.

    The result has, per state variable, an array of which values (columns) are in the box of each
    order (rows). All boxes grow at once: a value is added unless a refused combination has it and
    is outside the box in no other variable.
    """
    numbers = np.arange(len(orders))
    values = np.arange(max(shape))
    free = np.repeat((values == seed[:, None])[None], len(orders), axis=0)
    misses = np.repeat((refused != seed).T[None], len(orders), axis=0)
    total = misses.sum(axis=1)
    for variable in orders.T:
        theirs = refused.T[variable]
        own = misses[numbers, variable]
        free[numbers, variable] = True
        order, row = np.nonzero(total == own)
        free[order, variable[order], theirs[order, row]] = False
        misses[numbers, variable] = ~free[numbers[:, None], variable[:, None], theirs]
        total += misses[numbers, variable].astype(np.intp) - own
    return [free[:, variable, :size] for variable, size in enumerate(shape)]


def _best(grown: Sequence[Bools], left: Indexes) -> _Box:
    """Return the box that covers the most of what is left, then leaves the most variables free."""
    held = np.logical_and.reduce([free[:, left[:, at]] for at, free in enumerate(grown)])
    dropped = np.sum([free.all(axis=1) for free in grown], axis=0)
    order = max(range(len(held)), key=lambda each: (held[each].sum(), dropped[each]))
    return [free[order] for free in grown]


def _product(left: Bools, box: _Box) -> Product:
    """Return a box as masks; values are needed only for what no earlier box covers."""
    here = left[np.ix_(*box)]
    found = []
    for variable, free in enumerate(box):
        others = tuple(other for other in range(len(box)) if other != variable)
        used = np.zeros(len(free), np.bool_)
        used[np.flatnonzero(free)] = here.any(axis=others)
        found.append((_mask(used), _mask(free)))
    return tuple(found)


def _irredundant(inside: Bools, boxes: list[_Box]) -> list[Product]:
    """Return the boxes as products, without those that are covered by the others."""
    count = np.zeros(inside.shape, np.int32)
    for box in boxes:
        count[np.ix_(*box)] += 1
    left = inside.copy()
    found = []
    for box in boxes:
        grid = np.ix_(*box)
        if ((count[grid] > 1) | ~inside[grid]).all():
            count[grid] -= 1
        else:
            found.append(_product(left, box))
            left[grid] = False
    # Model order reads better than the order in which they were found.
    full = [full_mask(size) for size in inside.shape]
    return sorted(found, key=lambda box: [n for n, (_, free) in enumerate(box) if free != full[n]])


# --- expressions ---------------------------------------------------------------------------------


def _literal(plant: Plant, index: StateVariable, needed: int, free: int) -> Expr:
    """Return a condition on one state variable: all needed values and none that is not free."""
    match index.kind:
        case VariableKind.PHASE:
            active = PhaseRef(index.name, str(index.values[1]))
            return active if free & 2 else negation(active)
        case VariableKind.LOCATION:
            return _member(
                index.size, needed, free, lambda v: StateRef(index.name, str(index.values[v]))
            )
    variable = plant.leaf_of(index)
    if isinstance(index.values, Classes):
        return index.values.condition(_values(needed), _values(free)).of(variable)
    members = _member(index.size, needed, free, lambda v: has_value(variable, index.values[v]))
    if isinstance(variable.type, IntegerType):
        return min(_interval(index, variable, needed, free), members, key=_cost)
    return members


def _member(size: int, needed: int, free: int, is_value: Callable[[int], Expr]) -> Expr:
    """Return that the value is one of some, or none of the others: whichever names fewer."""
    some, others = _values(needed), _values(full_mask(size) - free)
    if len(some) <= len(others):
        return disjunction(map(is_value, some))
    return conjunction(negation(is_value(value)) for value in others)


def _mask(values: Bools) -> int:
    return sum(1 << value for value in np.flatnonzero(values).tolist())


def _values(mask: int) -> list[int]:
    return [value for value, bit in enumerate(reversed(f"{mask:b}")) if bit == "1"]


def _interval(index: StateVariable, variable: _Reference, some: int, most: int) -> Expr:
    """Return a disjunction of intervals, extended over free values where that saves a bound."""
    needed, free = set(_values(some)), set(_values(most))
    runs: list[Expr] = []
    for low, high in intervals(needed, free):
        inside = needed.intersection(range(low, high + 1))
        runs.append(_between(index, variable, (low, min(inside)), (max(inside), high)))
    return disjunction(runs)


def _between(
    index: StateVariable,
    variable: _Reference,
    lower: tuple[int, int],
    upper: tuple[int, int],
) -> Expr:
    """Return an interval between one of two lower and one of two upper bounds.

    The bound is left out where the outermost value reaches the end of the range.
    """

    def compare(op: str, place: int) -> Expr:
        return Binary(op, variable, Literal(index.values[place], variable.type), _BOOLEAN)

    parts = []
    if lower[0] > 0:
        parts.append(compare(">=", lower[0]))
    if upper[1] < index.size - 1:
        parts.append(compare("<=", upper[1]))
    return conjunction(parts)
