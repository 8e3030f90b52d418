"""Combinations of values that the parameters of an event can have, and what reads them."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable, Iterator, Mapping, Sequence
from itertools import product
from math import prod
from typing import TypeAlias

from robosc import limits
from robosc.errors import StateSpaceError
from robosc.expr.tree import Expr
from robosc.plant.automaton import Edge, Event
from robosc.plant.data.disjoint_sets import DisjointSets
from robosc.plant.event_values import values_read
from robosc.plant.logic import conjunction, disjunction, junction, negation
from robosc.plant.partial_evaluation import PartValues, holds
from robosc.plant.step import is_consistent, missing_together

_FEW = 2**8

Path: TypeAlias = tuple[str | int, ...]
_Signed: TypeAlias = tuple[Expr, bool]


def choices(event: Event, read: Iterable[Expr]) -> Iterator[PartValues]:
    """Yield the combinations of values of the parameters that are read; one, empty, if none is.

    Raises:
        StateSpaceError: there are more than ``limits.COMBINATIONS``.
    """
    paths = values_read(read)
    used = [i for i, p in enumerate(event.parameters) if p.path in paths]
    taken = [event.parameters[i] for i in used]
    if (number := prod(len(p.values) for p in taken)) > limits.COMBINATIONS:
        raise StateSpaceError(
            f"the parts of the value of {event.name} that are compared have {number} combinations"
            f" of outcomes, more than the limit of {limits.COMBINATIONS}: compare fewer of them in"
            " one message, or convert them by an enum"
        )
    implied = _implied(event)
    pairs = [(used.index(i), used.index(j)) for i in used for j in implied.get(i, ()) if j in used]
    never = [n for n, i in enumerate(used) if not _may_be_missing(event, i, implied)]
    for values in product(*(p.values for p in taken)):
        if any(values[n] is None for n in never):
            continue
        if is_consistent(values, pairs):
            yield {p.path: value for p, value in zip(taken, values, strict=True)}


def weight(event: Event) -> int:
    """Return the number of combinations of parameter values that an event can have."""
    implied = _implied(event)
    there = [len(p.values) - (None in p.values) for p in event.parameters]
    open_ = {i for i in implied if _may_be_missing(event, i, implied)}
    known: dict[frozenset[int], int] = {}

    def count(rest: frozenset[int]) -> int:
        """Return the number of combinations of parameters that may all be missing."""
        if not rest:
            return 1
        if rest not in known:
            known[rest] = prod(_either(part) for part in _connected(rest, implied))
        return known[rest]

    def _either(part: frozenset[int]) -> int:
        one = max(part, key=lambda i: (len(implied[i] & part), i))
        missing = {one} | implied[one]
        needed = {i for i in part if i == one or one in implied[i]}
        present = prod(there[i] for i in needed)
        return count(part - missing) + present * count(part - needed)

    always = prod(there[i] for i in range(len(there)) if i not in open_)
    return always * count(frozenset(open_))


def private_parameters(event: Event, edge: Edge) -> Mapping[int, tuple[int, ...]]:
    """Return, per variable that an edge assigns, the parameters that only this assignment reads.

    Neither a guard, nor another component, nor an assignment to another variable reads them, and
    whether they are missing says nothing about another parameter.
    """
    if len(event.parameters) < 2:
        return {}
    readers: Counter[Path] = Counter()
    for automaton in event.automata:
        guards = [e.guard for e in automaton.edges if e.guard is not None]
        updates = [expr for e in automaton.edges for _, expr in e.updates]
        readers.update(values_read(updates).keys())
        readers.update(values_read(guards).keys())
    by_variable: dict[int, set[Path]] = {}
    for variable, expr in edge.updates:
        by_variable.setdefault(variable, set()).update(values_read([expr]))
    readers.update(path for paths in by_variable.values() for path in paths)
    linked = {number for pair in missing_together(event) for number in pair}
    return {
        variable: tuple(
            number
            for number, parameter in enumerate(event.parameters)
            # one component, and one variable of this edge
            if parameter.path in paths and readers[parameter.path] == 2 and number not in linked
        )
        for variable, paths in by_variable.items()
    }


def for_some(event: Event, conditions: Sequence[Expr], few: int = _FEW) -> Expr:
    """Return the state condition that conditions hold together for some value of an event.

    Conjuncts that read different parameters are quantified separately, if more than ``few``
    combinations of their values would have to be tried.

    Raises:
        StateSpaceError: one of them has too many combinations of parameter values.
    """
    read = values_read(conditions)
    parameters = [p for p in event.parameters if p.path in read]
    simple = all(None not in p.values for p in parameters)
    if not simple or prod(len(p.values) for p in parameters) <= few:
        return _tried(event, conditions)
    return _some(event, [(condition, True) for condition in conditions])


def _some(event: Event, parts: Iterable[_Signed]) -> Expr:
    found: list[Expr] = []
    for group in _by_values(_conjuncts(parts)):
        either = junction(*group[0]) if len(group) == 1 else None
        if either is not None:  # a disjunction: conjunctions were split
            found.append(disjunction(_some(event, [part]) for part in either.parts))
        else:
            found.append(_tried(event, [e if sign else negation(e) for e, sign in group]))
    return conjunction(found)


def _tried(event: Event, conditions: Sequence[Expr]) -> Expr:
    return disjunction(
        conjunction(holds(condition, chosen) for condition in conditions)
        for chosen in choices(event, conditions)
    )


def _conjuncts(parts: Iterable[_Signed]) -> Iterator[_Signed]:
    for expr, sign in parts:
        taken = junction(expr, sign)
        if taken is None or not taken.conjunctive:
            yield expr, sign
        else:
            yield from _conjuncts(taken.parts)


def _by_values(parts: Iterable[_Signed]) -> list[list[_Signed]]:
    """Return the parts in groups; no two groups read the same parameter."""
    listed = list(parts)
    sets = DisjointSets()
    for number, (expr, _) in enumerate(listed):
        sets.join([number, *values_read([expr])])
    return [[listed[number] for number in group] for group in sets.groups(range(len(listed)))]


# --- missing parameters --------------------------------------------------------------------------


def _implied(event: Event) -> Mapping[int, set[int]]:
    """Return, per parameter that may be missing, those that are then missing, too."""
    optional = [i for i, p in enumerate(event.parameters) if None in p.values]
    implied: dict[int, set[int]] = {i: set() for i in optional}
    if optional:
        for i, j in missing_together(event):
            if i in implied:
                implied[i].add(j)
        for middle in optional:
            for found in implied.values():
                if middle in found:
                    found |= implied[middle]
    for i, found in implied.items():
        found.discard(i)
    return implied


def _may_be_missing(event: Event, number: int, implied: Mapping[int, set[int]]) -> bool:
    return number in implied and all(j in implied for j in implied[number])


def _connected(rest: frozenset[int], implied: Mapping[int, set[int]]) -> list[frozenset[int]]:
    """Return the parameters in parts that are missing independently of each other."""
    sets = DisjointSets()
    for one in rest:
        sets.join([one, *(implied[one] & rest)])
    return [frozenset(group) for group in sets.groups(rest)]
