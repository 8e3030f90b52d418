"""Care sets as sets of rows of values."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from dataclasses import replace
from math import prod
from operator import itemgetter
from typing import Any, TypeAlias

from robosc.expr.tree import Expr
from robosc.lazy_dataclasses import dataclass
from robosc.plant.automaton import PlantState
from robosc.plant.support import support
from robosc.synthesis.compiled_steps import Stepper
from robosc.synthesis.guards.minimise import condition_of
from robosc.synthesis.guards.sum_of_products import Diagrams

_Row: TypeAlias = tuple[int, ...]
_Key: TypeAlias = Callable[[_Row], _Row]
Rows: TypeAlias = frozenset[_Row]


@dataclass(frozen=True, eq=False)
class ExplicitCareSet:
    """A :class:`~robosc.synthesis.guards.shorten.CareSet`: rows of the values of ``variables``."""

    stepper: Stepper
    variables: tuple[int, ...]
    allowed: Rows
    refused: Rows

    @property
    def parts(self) -> tuple[tuple[int, ...], ...]:
        return tuple((variable,) for variable in self.variables)

    @property
    def size(self) -> int:
        return prod(self.stepper.plant.sizes(self.variables))

    def without(self, parts: Sequence[tuple[int, ...]]) -> ExplicitCareSet | None:
        gone = {variable for part in parts for variable in part}
        places = [n for n, variable in enumerate(self.variables) if variable not in gone]
        small, large = sorted((self.allowed, self.refused), key=len)
        few = _projected(small, places)
        many = _projected(large, places)
        if not few.isdisjoint(many):
            return None
        allowed, refused = (few, many) if small is self.allowed else (many, few)
        variables = tuple(self.variables[place] for place in places)
        return ExplicitCareSet(self.stepper, variables, allowed, refused)

    def within(self, allowed: Expr, refused: Expr) -> ExplicitCareSet | None:
        if not self._has(allowed) or not self._has(refused):
            return None
        some, none = self._split(self.allowed, allowed), self._split(self.refused, refused)
        return replace(self, allowed=some[0], refused=none[0])

    def separates(self, condition: Expr) -> bool:
        if not self._has(condition):
            return False
        key, holds = self._test(condition)
        return all(map(holds, {*map(key, self.allowed)})) and not any(
            map(holds, {*map(key, self.refused)})
        )

    def _has(self, condition: Expr) -> bool:
        """Whether a condition reads no state variable that was projected away."""
        return {*self.variables}.issuperset(support(self.stepper.plant, condition))

    def _split(self, rows: Rows, condition: Expr) -> tuple[Rows, Rows]:
        """Return the rows in which a condition holds, and the others."""
        key, holds = self._test(condition)
        known = {values: holds(values) for values in {*map(key, rows)}}
        inside = frozenset(row for row in rows if known[key(row)])
        return inside, rows - inside

    def _test(self, condition: Expr) -> tuple[_Key, Callable[[_Row], bool]]:
        """Return what a condition reads of a row, and whether it holds for that."""
        read = support(self.stepper.plant, condition)
        test = self.stepper.test(condition)
        state = list(self.stepper.plant.initial)

        def holds(values: _Row) -> bool:
            for variable, value in zip(read, values, strict=True):
                state[variable] = value
            return test(tuple(state))

        return _chooser([self.variables.index(variable) for variable in read]), holds

    def condition(self, order: Callable[[int], Any], most_steps: int) -> Expr:
        left = self
        for variable in sorted(self.variables, key=order):
            left = left.without([(variable,)]) or left
        diagrams = Diagrams(self.stepper.plant.sizes(left.variables), most_steps)
        sets = diagrams.of_rows(left.allowed), diagrams.of_rows(left.refused)
        return condition_of(self.stepper.plant, left.variables, diagrams, *sets)


def care_set(
    stepper: Stepper, allowed: Iterable[PlantState], refused: Iterable[PlantState]
) -> ExplicitCareSet:
    """Return the care set of states."""
    variables = tuple(range(len(stepper.plant.variables)))
    return ExplicitCareSet(stepper, variables, frozenset(allowed), frozenset(refused))


def _projected(rows: Rows, places: Sequence[int]) -> Rows:
    return frozenset(map(_chooser(places), rows))


def _chooser(places: Sequence[int]) -> _Key:
    """Return a function from rows to their values at some places, as a row."""
    match places:
        case []:
            return lambda row: ()
        case [place]:
            return lambda row: (row[place],)
    return itemgetter(*places)
