"""The transition rules of one event, and merging those with equal conditions."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from dataclasses import dataclass
from math import prod
from typing import TypeAlias

from robosc.plant.automaton import Event
from robosc.synthesis.vectorised import Bools, IndexArrays

Writes: TypeAlias = tuple[tuple[tuple[int, ...], tuple[int, ...]], ...]
"""Rectangles (old values, new values): each old value of one leads to each new value of it."""


@dataclass(frozen=True, eq=False, slots=True)
class Factor:
    """A test over several state variables: returns a boolean array for columns of their values."""

    variables: tuple[int, ...]
    test: Callable[[IndexArrays], Bools]


@dataclass(frozen=True, eq=False, slots=True)
class Condition:
    """A conjunction: each variable has a value in its ``allowed`` array, and each factor holds."""

    allowed: dict[int, Bools]
    factors: tuple[Factor, ...] = ()

    def key(self) -> tuple[object, ...]:
        """Return a key that is equal for equal conditions; factors count by identity."""
        return (
            tuple(
                (variable, self.allowed[variable].tobytes()) for variable in sorted(self.allowed)
            ),
            frozenset(self.factors),
        )

    def both(self, other: Condition) -> Condition | None:
        """Return the conjunction; None if no value of some state variable is left."""
        allowed = dict(self.allowed)
        for variable, values in other.allowed.items():
            kept = allowed[variable] & values if variable in allowed else values
            if not kept.any():
                return None
            allowed[variable] = kept
        return Condition(allowed, tuple(dict.fromkeys((*self.factors, *other.factors))))


ALWAYS = Condition({})


@dataclass(frozen=True, eq=False, slots=True)
class TransitionRule:
    """Where ``condition`` holds, the state variables in ``writes`` change as given there."""

    condition: Condition
    writes: dict[int, Writes]


@dataclass(frozen=True, eq=False)
class EventRules:
    """The rules of one event of the plant, in stages (:mod:`robosc.synthesis.dense.transitions`).

    ``range_violations`` are where an update would leave its range, for some parameter values.
    ``required`` are conditions that exclude each other; the requirement is their disjunction.
    ``weight`` is the number of combinations of parameter values.
    """

    event: Event
    stages: tuple[tuple[TransitionRule, ...], ...]
    range_violations: tuple[Condition, ...]
    required: tuple[Condition, ...]
    weight: int


def as_writes(images: dict[int, set[int]]) -> Writes:
    """Return a relation as rectangles, one for all old values with equal images."""
    found: dict[tuple[int, ...], list[int]] = {}
    for old, new in images.items():
        found.setdefault(tuple(sorted(new)), []).append(old)
    return tuple((tuple(old), new) for new, old in found.items())


def _union(writes: Iterable[Writes]) -> Writes:
    together: dict[tuple[int, ...], set[int]] = {}
    for one in writes:
        for old, new in one:
            together.setdefault(old, set()).update(new)
    if len(together) == 1:  # mostly the assignment of a parameter: too many pairs to list
        return tuple((old, tuple(sorted(new))) for old, new in together.items())
    images: dict[int, set[int]] = {}
    for old, after in together.items():
        for value in old:
            images.setdefault(value, set()).update(after)
    return as_writes(images)


class Merger:
    """Collects rules; those with one condition whose writes form a product become one rule."""

    def __init__(self) -> None:
        self._found: dict[tuple[object, ...], tuple[Condition, list[dict[int, Writes]]]] = {}

    def add(self, condition: Condition, writes: dict[int, Writes]) -> None:
        self._found.setdefault(condition.key(), (condition, []))[1].append(writes)

    def rules(self) -> tuple[TransitionRule, ...]:
        found: list[TransitionRule] = []
        for condition, several in self._found.values():
            distinct = list({tuple(sorted(w.items())): w for w in several}.values())
            merged = _product(distinct) if len(distinct) > 1 else None
            found.extend(TransitionRule(condition, w) for w in ([merged] if merged else distinct))
        return tuple(found)


def _product(several: list[dict[int, Writes]]) -> dict[int, Writes] | None:
    """Return one write for several, if these are all combinations of writes per variable."""
    variables = several[0].keys()
    if any(writes.keys() != variables for writes in several):
        return None
    per_variable = {
        variable: dict.fromkeys(writes[variable] for writes in several) for variable in variables
    }
    if prod(len(each) for each in per_variable.values()) != len(several):
        return None
    return {
        variable: _union(each) if len(each) > 1 else next(iter(each))
        for variable, each in per_variable.items()
    }
