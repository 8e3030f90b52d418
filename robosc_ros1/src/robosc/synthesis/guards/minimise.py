"""Short conditions for a set of combinations of values, by two-level minimisation.

A set is written as a sum of products (:mod:`robosc.synthesis.guards.sum_of_products`), or as the
negation of one for what is refused; a product restricts each state variable to some of its values.
Compare Rudell & Sangiovanni-Vincentelli, "Multiple-valued minimization for PLA optimization", IEEE
Trans. CAD 6(5), 1987.
"""

from __future__ import annotations

from collections.abc import Callable, Collection, Iterable, Sequence
from contextlib import suppress
from functools import cache
from typing import TypeAlias

from robosc.expr.traversal import walk
from robosc.expr.tree import FALSE, TRUE, Binary, Expr, Literal, TestRef, Unary, VariableRef
from robosc.expr.types import BooleanType, IntegerType
from robosc.plant.automaton import Plant, StateVariable, VariableKind
from robosc.plant.data.cases import has_value
from robosc.plant.data.classes import Classes, intervals
from robosc.plant.logic import conjunction, disjunction, negation
from robosc.plant.places import in_phases, in_states
from robosc.synthesis.guards.sum_of_products import Diagrams, Product, TooLarge, full_mask

_BOOLEAN = BooleanType()
_Reference: TypeAlias = VariableRef | TestRef


def condition_of(
    plant: Plant, variables: Sequence[int], diagrams: Diagrams, allowed: int, refused: int
) -> Expr:
    """Return an expression that holds in what is allowed and fails in what is refused.

    It is the shorter one: a sum of products for the first set, or the negation of one for the
    second.

    Raises:
        TooLarge: neither set has a sum of products of a reasonable length.
    """
    found: list[Expr] = []
    for inside, outside, positive in ((allowed, refused, True), (refused, allowed, False)):
        with suppress(TooLarge):
            products = diagrams.products(inside, diagrams.complement(outside))
            found.append(_joined(plant, variables, products, positive))
    if not found:
        raise TooLarge("a guard would be too long")
    return min(found, key=_cost)


def condition_on(plant: Plant, variable: int, indexes: Collection[int]) -> Expr:
    """Return an expression that a state variable has a value with one of some indexes."""
    mask = sum(1 << index for index in indexes)
    if mask in (0, full_mask(plant.variables[variable].size)):
        return TRUE if mask else FALSE
    return _literal(plant, plant.variables[variable], mask, mask)


def _joined(
    plant: Plant, variables: Sequence[int], products: Iterable[Product], positive: bool
) -> Expr:
    """Return the condition of being in some product, or in none if not ``positive``."""

    @cache
    def literal(variable: int, needed: int, free: int) -> Expr:
        return _literal(plant, plant.variables[variable], needed, free)

    def literals(product: Product) -> Iterable[Expr]:
        """Yield the condition on each state variable of a product, or of its negation."""
        for variable, (needed, free) in zip(variables, product, strict=True):
            full = full_mask(plant.variables[variable].size)
            if free != full:
                low, high = (needed, free) if positive else (full - free, full - needed)
                yield literal(variable, low, high)

    if positive:
        return disjunction(conjunction(literals(product)) for product in products)
    return conjunction(disjunction(literals(product)) for product in products)


def _cost(expr: Expr) -> tuple[int, int]:
    leaves = negations = 0
    for node in walk(expr):
        if isinstance(node, Unary):
            negations += 1
        elif not isinstance(node, Binary | Literal):
            leaves += 1
    return leaves, negations


# --- expressions ---------------------------------------------------------------------------------


def _literal(plant: Plant, index: StateVariable, needed: int, free: int) -> Expr:
    """Return a condition on one state variable: all needed values and none that is not free."""
    match index.kind:
        case VariableKind.PHASE:
            if index.size == 2:
                return index.phase(1 if free & 2 else 0)
            communication = plant.robot.communications[index.name]

            def phases(chosen: Sequence[int]) -> Iterable[Expr]:
                named = in_phases(communication, [str(index.values[v]) for v in chosen if v])
                return named if all(chosen) else [index.phase(0), *named]

            return _member(index.size, needed, free, phases)
        case VariableKind.LOCATION:

            def states(chosen: Sequence[int]) -> Iterable[Expr]:
                return in_states(plant.robot, index.name, [str(index.values[v]) for v in chosen])

            return _member(index.size, needed, free, states)
    variable = plant.leaf_of(index)
    if isinstance(index.values, Classes):
        return index.values.condition(_values(needed), _values(free)).of(variable)

    def values(chosen: Sequence[int]) -> Iterable[Expr]:
        return (has_value(variable, index.values[value]) for value in chosen)

    members = _member(index.size, needed, free, values)
    if isinstance(variable.type, IntegerType):
        return min(_interval(index, variable, needed, free), members, key=_cost)
    return members


def _member(
    size: int, needed: int, free: int, named: Callable[[Sequence[int]], Iterable[Expr]]
) -> Expr:
    """Return that the value is one of some, or none of the others: whichever names fewer.

    ``named`` gives conditions of which one holds for each of some values.
    """
    some, others = _values(needed), _values(full_mask(size) - free)
    if len(some) <= len(others):
        return disjunction(named(some))
    return conjunction(map(negation, named(others)))


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
