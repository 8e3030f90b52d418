"""Conditions for a set of combinations of values, as short as a greedy cover makes them.

Two-level minimisation over state variables of several values: a *box* is a set of values per state
variable. Boxes are grown from single combinations as far as nothing refused gets in, then chosen
until all that is allowed is covered (a disjunction), or all that is refused (a conjunction of
negated boxes); the shorter of the two is taken. Compare Rudell & Sangiovanni-Vincentelli,
"Multiple-valued minimization for PLA optimization", IEEE Trans. CAD 6(5), 1987.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass
from typing import Any, TypeAlias

import numpy as np

from robosc.ir.automaton import Plant, StateVariable, VariableKind
from robosc.ir.finite.classes import Classes
from robosc.ir.formulas import conjunction, disjunction, negation
from robosc.model.entities import Variable
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
from robosc.synthesis.sum_of_products import Diagrams, Product, TooLarge
from robosc.synthesis.vectorised import Bools

__all__ = ["LARGEST_TABLE", "Table", "condition_of", "condition_of_products"]

_BOOLEAN = BooleanType()
_Reference: TypeAlias = VariableRef | TestRef

LARGEST_TABLE = 2**10
"""Combinations beyond which a greedy cover takes too long: it looks at all of them for each box."""
_MOST_BOXES = 32
"""Boxes beyond which a sum of products is sooner found, and not longer."""


@dataclass(frozen=True, eq=False)
class Table:
    """Two disjoint sets of combinations: boolean arrays with one dimension per state variable."""

    variables: tuple[int, ...]
    allowed: Bools
    refused: Bools

    def reduced(self, order: Callable[[int], Any]) -> Table:
        """Without state variables that the two sets need not be distinguished by, in that order."""
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


@dataclass(frozen=True, eq=False)
class _Box:
    """Per state variable the values that must be in, and those that may."""

    needed: tuple[Bools, ...]
    free: tuple[Bools, ...]


def condition_of(plant: Plant, table: Table) -> Expr:
    """An expression that holds in what is allowed and fails in what is refused."""
    if not table.allowed.any():
        return FALSE
    if not table.refused.any():
        return TRUE
    variables = [plant.variables[variable] for variable in table.variables]
    found: list[Expr] = []
    for inside, outside, positive in (
        (table.allowed, table.refused, True),
        (table.refused, table.allowed, False),
    ):
        try:
            found.append(_joined(plant, variables, _cover(inside, outside), positive))
        except TooLarge:
            continue
    if found:
        return min(found, key=_cost)
    diagrams = Diagrams([variable.size for variable in variables])
    sets = [diagrams.of_rows(np.argwhere(each)) for each in (table.allowed, table.refused)]
    return condition_of_products(plant, table.variables, diagrams, *sets)


def condition_of_products(
    plant: Plant, variables: Sequence[int], diagrams: Diagrams, allowed: int, refused: int
) -> Expr:
    """The same for two sets over many state variables, told by decision diagrams.

    Raises:
        TooLarge: neither set has a sum of products of a reasonable length.
    """
    found: list[Expr] = []
    for inside, outside, positive in ((allowed, refused, True), (refused, allowed, False)):
        try:
            products = diagrams.products(inside, diagrams.complement(outside))
        except TooLarge:
            continue
        boxes = [_box_of(product, diagrams.sizes) for product in products]
        found.append(
            _joined(plant, [plant.variables[variable] for variable in variables], boxes, positive)
        )
    if not found:
        raise TooLarge("a guard would be too long")
    return min(found, key=_cost)


def _box_of(product: Product, sizes: Sequence[int]) -> _Box:
    masks = [
        [np.array([mask >> value & 1 for value in range(size)], np.bool_) for mask in pair]
        for pair, size in zip(product, sizes, strict=True)
    ]
    return _Box(tuple(needed for needed, _ in masks), tuple(free for _, free in masks))


def _joined(
    plant: Plant, variables: Sequence[StateVariable], boxes: Iterable[_Box], positive: bool
) -> Expr:
    """What holds in some box, or in none if not ``positive``."""
    if positive:
        return disjunction(conjunction(_literals(plant, variables, box, True)) for box in boxes)
    return conjunction(disjunction(_literals(plant, variables, box, False)) for box in boxes)


def _cost(expr: Expr) -> tuple[int, int]:
    leaves = negations = 0
    for node in walk(expr):
        if isinstance(node, Unary):
            negations += 1
        elif not isinstance(node, Binary | Literal):
            leaves += 1
    return leaves, negations


# --- boxes ---------------------------------------------------------------------------------------


def _cover(inside: Bools, outside: Bools) -> list[_Box]:
    """Boxes that hold all of ``inside`` and nothing of ``outside``."""
    left = inside.copy()
    boxes: list[_Box] = []
    while left.any():
        seed = np.unravel_index(int(np.argmax(left)), left.shape)
        grown = [_grow(seed, outside, order) for order in _orders(left.ndim)]
        best = max(grown, key=lambda free: (int(left[np.ix_(*free)].sum()), _dropped(free)))
        boxes.append(_box(left, best))
        if len(boxes) > _MOST_BOXES:
            raise TooLarge("a cover takes too many boxes")
        left[np.ix_(*best)] = False
    return _irredundant(inside, boxes)


def _orders(count: int) -> list[list[int]]:
    """Some orders in which to grow a box; each state variable comes first once, both ways round."""
    forward = list(range(count))
    found = []
    for start in range(count):
        turned = forward[start:] + forward[:start]
        found += [turned, turned[:1] + turned[:0:-1]]
    return found or [[]]


def _grow(seed: Sequence[Any], outside: Bools, order: Sequence[int]) -> list[Bools]:
    """A box around one combination, as wide as ``outside`` lets it be."""
    free = [np.arange(size) == at for size, at in zip(outside.shape, seed, strict=True)]
    for variable in order:
        everything = np.ones(outside.shape[variable], np.bool_)
        slab = [everything if other == variable else values for other, values in enumerate(free)]
        others = tuple(other for other in range(len(free)) if other != variable)
        free[variable] = ~outside[np.ix_(*slab)].any(axis=others)
    return free


def _dropped(free: Sequence[Bools]) -> int:
    return sum(bool(values.all()) for values in free)


def _box(left: Bools, free: Sequence[Bools]) -> _Box:
    """A box that need not hold more than the combinations that no earlier one holds."""
    here = left[np.ix_(*free)]
    needed = []
    for variable, values in enumerate(free):
        others = tuple(other for other in range(len(free)) if other != variable)
        used = np.zeros(len(values), np.bool_)
        used[np.flatnonzero(values)] = here.any(axis=others)
        needed.append(used)
    return _Box(tuple(needed), tuple(free))


def _irredundant(inside: Bools, boxes: list[_Box]) -> list[_Box]:
    """Without boxes that the others make superfluous; what is needed is computed anew."""
    if len(boxes) < 2:
        return boxes
    count = np.zeros(inside.shape, np.int32)
    for box in boxes:
        count[np.ix_(*box.free)] += 1
    kept = []
    for box in boxes:
        grid = np.ix_(*box.free)
        if ((count[grid] > 1) | ~inside[grid]).all():
            count[grid] -= 1
        else:
            kept.append(box)
    left = inside.copy()
    result = []
    for box in kept:
        result.append(_box(left, box.free))
        left[np.ix_(*box.free)] = False
    # Model order reads better than the order in which they were found.
    return sorted(result, key=lambda box: [at for at, f in enumerate(box.free) if not f.all()])


# --- wording -------------------------------------------------------------------------------------


def _literals(
    plant: Plant, variables: Sequence[StateVariable], box: _Box, positive: bool
) -> list[Expr]:
    """What a box says of each state variable, or what its negation says."""
    found = []
    for variable, needed, free in zip(variables, box.needed, box.free, strict=True):
        if not free.all():
            low, high = (needed, free) if positive else (~free, ~needed)
            found.append(_literal(plant, variable, low, high))
    return found


def _literal(plant: Plant, index: StateVariable, needed: Bools, free: Bools) -> Expr:
    """A condition on one state variable: all needed values, and no others than the free."""
    match index.kind:
        case VariableKind.PHASE:
            active = PhaseRef(index.name, str(index.values[1]))
            return active if free[1] else negation(active)
        case VariableKind.LOCATION:
            return _member(needed, free, lambda v: StateRef(index.name, str(index.values[v])))
    variable = _reference(plant, index)
    type_ = variable.type
    if isinstance(index.values, Classes):
        values = [[int(v) for v in np.flatnonzero(those)] for those in (needed, free)]
        return index.values.condition(*values).of(variable)
    if isinstance(type_, BooleanType):
        value = bool(index.values[int(np.flatnonzero(needed)[0])])
        return variable if value else negation(variable)

    def equals(value: int) -> Expr:
        return Binary("=", variable, Literal(index.values[value], type_), _BOOLEAN)

    members = _member(needed, free, equals)
    if isinstance(type_, IntegerType):
        return min(_interval(index, variable, needed, free), members, key=_cost)
    return members


def _reference(plant: Plant, variable: StateVariable) -> _Reference:
    """What reads a variable or a test."""
    if variable.test is not None:
        return variable.test
    component, name = variable.name.split(".")
    type_ = next(v.type for v in _variables(plant, component) if v.name == name)
    return VariableRef(component, name, type_)


def _variables(plant: Plant, component: str) -> tuple[Variable, ...]:
    behaviour = plant.robot.component(component).behaviour
    return () if behaviour is None else behaviour.variables


def _member(needed: Bools, free: Bools, is_value: Callable[[int], Expr]) -> Expr:
    """One of some values, or none of the others: whichever names fewer."""
    some = [is_value(int(v)) for v in np.flatnonzero(needed)]
    others = [negation(is_value(int(v))) for v in np.flatnonzero(~free)]
    return disjunction(some) if len(some) <= len(others) else conjunction(others)


def _interval(index: StateVariable, variable: _Reference, needed: Bools, free: Bools) -> Expr:
    """Runs of values, each given by its bounds; they stretch over free values where that helps."""
    runs: list[Expr] = []
    last = len(needed) - 1
    place = 0
    while place <= last:
        if not needed[place]:
            place += 1
            continue
        low = place
        while low > 0 and free[low - 1]:
            low -= 1
        end = high = place
        while high < last and free[high + 1]:
            high += 1
            end = high if needed[high] else end
        runs.append(_between(index, variable, (low, place), (end, high)))
        place = high + 1
    return disjunction(runs)


def _between(
    index: StateVariable,
    variable: _Reference,
    lower: tuple[int, int],
    upper: tuple[int, int],
) -> Expr:
    """From one of the lower places to one of the upper ones; open where they reach the end."""

    def compare(op: str, place: int) -> Expr:
        return Binary(op, variable, Literal(index.values[place], variable.type), _BOOLEAN)

    parts = []
    if lower[0] > 0:
        parts.append(compare(">=", lower[0]))
    if upper[1] < index.size - 1:
        parts.append(compare("<=", upper[1]))
    return conjunction(parts)
