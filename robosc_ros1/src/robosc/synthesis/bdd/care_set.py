"""Care sets as decision diagrams.

Most guards read a few state variables: their care sets are minimised in the same way for both
engines (:mod:`robosc.synthesis.guards.minimise`). Where a guard reads so many that no sum of
products is found, it is covered by boxes computed on the diagrams themselves: each grows from a
single combination as far as nothing refused gets in.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import replace
from functools import cached_property
from math import prod
from typing import Any, TypeVar

from robosc.errors import StateSpaceError
from robosc.expr.tree import Expr
from robosc.lazy_dataclasses import dataclass
from robosc.plant.automaton import Plant
from robosc.plant.logic import conjunction, disjunction
from robosc.synthesis.bdd.encoding import Encoding
from robosc.synthesis.bdd.manager import Bdd
from robosc.synthesis.guards.greedy_selection import drop
from robosc.synthesis.guards.minimise import condition_of, condition_on
from robosc.synthesis.guards.sum_of_products import END, NOTHING, Diagrams, TooLarge

_Result = TypeVar("_Result")

_FEW = 2**10
"""Combinations up to which variables are in the plant's order, as those of the explicit engine."""
_MOST_VARIABLES = 200
"""State variables above which no sum of products is tried: it recurses over them."""


@dataclass(frozen=True, eq=False)
class BddCareSet:
    """Diagrams over the remaining state variables.

    A :class:`~robosc.synthesis.guards.shorten.CareSet`.
    """

    encoding: Encoding
    variables: tuple[int, ...]
    allowed: Bdd
    refused: Bdd

    @property
    def parts(self) -> tuple[tuple[int, ...], ...]:
        return tuple((variable,) for variable in self.variables)

    def without(self, parts: Sequence[tuple[int, ...]]) -> BddCareSet | None:
        manager = self.encoding.manager
        variables = {variable for part in parts for variable in part}
        cube = self.encoding.now(variables)
        # Projecting one of the sets is enough to see whether both would overlap: the smaller one.
        small, large = self._by_size
        projected = manager.exists(small, cube)
        if not manager.disjoint(projected, large):
            return None
        other = manager.exists(large, cube)
        some, none = (projected, other) if small is self.allowed else (other, projected)
        left = tuple(variable for variable in self.variables if variable not in variables)
        return BddCareSet(self.encoding, left, some, none)

    @cached_property
    def _by_size(self) -> list[Bdd]:
        return sorted((self.allowed, self.refused), key=self.encoding.manager.size)

    def within(self, allowed: Expr, refused: Expr) -> BddCareSet | None:
        try:
            some, none = map(self.encoding.holds, (allowed, refused))
        except StateSpaceError:
            return None
        return replace(self, allowed=self.allowed & some, refused=self.refused & none)

    def separates(self, condition: Expr) -> bool:
        encoding, false = self.encoding, self.encoding.manager.false
        try:
            if encoding.where(self.refused, condition) != false:
                return False
            return encoding.where(self.allowed, condition) == self.allowed
        except StateSpaceError:
            return False

    @property
    def size(self) -> int:
        return prod(self.encoding.plant.variables[variable].size for variable in self.variables)

    def condition(self, order: Callable[[int], Any], most_steps: int) -> Expr:
        plant = self.encoding.plant
        place = None if self.size <= _FEW else self.encoding.place
        variables = tuple(sorted(self.variables, key=place))
        if len(variables) > _MOST_VARIABLES:
            raise TooLarge("a guard reads too many state variables")
        diagrams = Diagrams(plant.sizes(variables), most_steps)

        def node(children: list[int]) -> int:
            diagrams.step(len(children))
            return diagrams.node(children)

        allowed, refused = (
            self._folded(states, variables, lambda depth: NOTHING, END, node)
            for states in (self.allowed, self.refused)
        )
        return condition_of(plant, variables, diagrams, allowed, refused)

    def _folded(
        self,
        states: Bdd,
        variables: Sequence[int],
        nothing: Callable[[int], _Result],
        end: _Result,
        node: Callable[[list[_Result]], _Result],
    ) -> _Result:
        """Return the result for a set over state variables, computed from those for its subsets.

        ``node`` is called with the results for each value of a state variable, over those that
        follow; ``nothing`` returns the result for the empty set of those from a place on, ``end``
        is that for the empty combination. Each subset is visited once.
        """
        encoding, manager = self.encoding, self.encoding.manager
        cubes = [encoding.now([variable]) for variable in variables]
        known: dict[tuple[int, Bdd], _Result] = {}

        def result(depth: int, states: Bdd) -> _Result:
            if states == manager.false:
                return nothing(depth)
            if depth == len(variables):
                return end
            if (depth, states) not in known:
                variable = variables[depth]
                values = range(encoding.plant.variables[variable].size)
                sets = (encoding.value(variable, index) for index in values)
                known[depth, states] = node(
                    [result(depth + 1, manager.and_exists(states, s, cubes[depth])) for s in sets]
                )
            return known[depth, states]

        return result(0, states)


# --- guards over very many state variables -------------------------------------------------------


def wide_condition(cases: BddCareSet) -> Expr:
    """Return an expression that holds in what is allowed and fails in what is refused."""
    parts = sorted(cases.parts, reverse=True)
    cases = drop(parts, cases, lambda left, some: left.without(some))
    cover = _Cover(cases)
    some, none = (
        cover.boxes(cases.allowed, cases.refused),
        cover.boxes(cases.refused, cases.allowed),
    )
    positive: list[Expr] = []
    negative: list[Expr] = []
    # Boxes of both covers in turn: the one that is complete first has fewer.
    while True:
        if (box := next(none, None)) is None:
            return conjunction(negative)
        negative.append(disjunction(cover.literals(box, False)))
        if (box := next(some, None)) is None:
            return disjunction(positive)
        positive.append(conjunction(cover.literals(box, True)))


_Box = dict[int, frozenset[int]]
"""Per state variable that is restricted, the values that it may have."""


class _Cover:
    """A cover by boxes, computed on decision diagrams; a box is a set of values per variable."""

    def __init__(self, cases: BddCareSet) -> None:
        self.encoding = cases.encoding
        self.plant: Plant = cases.encoding.plant
        self.variables = tuple(sorted(cases.variables))

    def boxes(self, inside: Bdd, outside: Bdd) -> Iterator[_Box]:
        """Yield boxes that together contain all of ``inside`` and nothing of ``outside``."""
        left = inside
        while left != self.encoding.manager.false:
            seed = self.encoding.pick(left)
            grown = [
                self._grow(seed, outside, order) for order in (self.variables, self.variables[::-1])
            ]
            best = max(grown, key=lambda box: self.encoding.count(left & self.encoding.box(box)))
            left = left & ~self.encoding.box(best)
            yield best

    def literals(self, box: _Box, positive: bool) -> Iterator[Expr]:
        """Yield the condition on each state variable of a box, or of its negation."""
        for variable in sorted(box):
            values = box[variable]
            if not positive:
                values = frozenset(range(self.plant.variables[variable].size)) - values
            yield condition_on(self.plant, variable, values)

    def _grow(self, seed: Sequence[int], outside: Bdd, order: Sequence[int]) -> _Box:
        """Return a maximal box around one combination, disjoint from ``outside``."""
        encoding = self.encoding
        rest = [encoding.manager.true]
        for variable in reversed(order):
            rest.append(encoding.value(variable, seed[variable]) & rest[-1])
        box: _Box = {}
        for number, variable in enumerate(order):
            near = outside & rest[len(order) - number - 1]
            size = self.plant.variables[variable].size
            values = frozenset(
                index
                for index in range(size)
                if near & encoding.value(variable, index) == encoding.manager.false
            )
            if len(values) < size:
                box[variable] = values
                outside = outside & encoding.values(variable, values)
        return box
