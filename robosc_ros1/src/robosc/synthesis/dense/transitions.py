"""Compilation of the plant's events to transition rules over state variables.

An event is a set of *rules*. A rule has a condition, a conjunction of sets of values per state
variable and of tests over several state variables, and writes: per state variable, which old values
lead to which new ones. For one combination of parameter values the conditions of an event's rules
are mutually exclusive; combinations with equal effects share one rule, whose writes are then sets.

Events with many automata are split into *stages*, sets of rules that are applied one after another.
No stage writes what a later one reads, so the result equals simultaneous application; within a
stage exactly one rule holds in every state in which the event is possible.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Collection, Iterable, Iterator, Sequence
from dataclasses import dataclass, replace
from itertools import product
from math import prod
from typing import Any

import numpy as np
from numpy.typing import NDArray

from robosc.expr.tree import Expr, Unary, ValueRef
from robosc.expr.types import BooleanType, EnumType
from robosc.plant.automaton import Edge, Event, LocalAutomaton, Plant
from robosc.plant.data.classes import Classes
from robosc.plant.event_values import values_read
from robosc.plant.logic import junction
from robosc.plant.partial_evaluation import PartValues, assigned, holds
from robosc.plant.support import support
from robosc.synthesis.dense.image_stages import stages_of
from robosc.synthesis.dense.merging import (
    ALWAYS,
    Condition,
    EventRules,
    Factor,
    Merger,
    TransitionRule,
    Writes,
    as_writes,
)
from robosc.synthesis.event_parameters import choices, weight
from robosc.synthesis.vectorised import Bools, IndexArrays, evaluate_vectorised

_WIDE = 2**16
"""Combinations of values above which an expression is not evaluated as a whole."""


@dataclass(frozen=True, slots=True)
class _Option:
    """One way for a component to take part in an event, the same in several locations.

    ``targets`` are pairs of locations (source, target); ``fails`` are guards of earlier edges.
    """

    variable: int
    targets: tuple[tuple[int, int], ...]
    fails: tuple[Expr, ...]
    guard: Expr | None
    updates: tuple[tuple[int, Expr], ...]

    def expressions(self) -> Iterator[Expr]:
        yield from self.fails
        if self.guard is not None:
            yield self.guard
        for _, expr in self.updates:
            yield expr


class Compiler:
    """Compiles the events and conditions of one plant; each distinct test is compiled once."""

    def __init__(self, plant: Plant) -> None:
        self.plant = plant
        self._tests: dict[tuple[object, ...], Condition | None] = {}

    def condition(self, expr: Expr, polarity: bool = True) -> tuple[Condition, ...]:
        """Return mutually exclusive conditions whose disjunction is: ``expr`` is ``polarity``."""
        return self._all_of([(expr, polarity)])

    def is_wide(self, expr: Expr) -> bool:
        """Whether an expression reads too many combinations of values to be one test."""
        return prod(self.plant.sizes(support(self.plant, expr))) > _WIDE

    def event(self, event: Event) -> EventRules:
        """Return the rules of an event of the plant."""
        entry = ALWAYS
        writes: dict[int, Writes] = {}
        if event.phase is not None:
            phase = event.phase
            entry = Condition({phase.variable: self.values(phase.variable, phase.sources)})
            if phase.sources != (phase.target,):
                writes[phase.variable] = ((phase.sources, (phase.target,)),)
        stages: list[tuple[TransitionRule, ...]] = []
        range_violations: list[Condition] = []
        for number, group in enumerate(stages_of(self.plant, event)):
            start, written = (ALWAYS, {}) if number else (entry, writes)
            rules, out = self._stage(event, group, start, written)
            stages.append(rules)
            range_violations.extend(both for one in out if (both := one.both(entry)) is not None)
        required = (ALWAYS,) if event.requirement is None else self.condition(event.requirement)
        return EventRules(event, tuple(stages), tuple(range_violations), required, weight(event))

    # --- conditions

    def _all_of(self, parts: Iterable[tuple[Expr, bool]]) -> tuple[Condition, ...]:
        conditions: list[Condition] = [ALWAYS]
        for part, polarity in parts:
            conditions = _conjoin(conditions, self._cases(part, polarity))
        return tuple(conditions)

    def _cases(self, expr: Expr, polarity: bool) -> tuple[Condition, ...]:
        if isinstance(expr, Unary):
            return self._cases(expr.operand, not polarity)
        parts = junction(expr, polarity)
        if parts is not None and parts.conjunctive:
            return self._all_of(parts.parts)
        if parts is not None and self.is_wide(expr):
            # Split into mutually exclusive cases, each of which reads fewer state variables.
            return self._either(*parts.parts)

        def test(columns: IndexArrays) -> Bools:
            outcome = evaluate_vectorised(self.plant, expr, columns).astype(np.bool_)
            return outcome if polarity else np.logical_not(outcome)

        return self._test((expr, polarity), support(self.plant, expr), test)

    def _either(self, first: tuple[Expr, bool], second: tuple[Expr, bool]) -> tuple[Condition, ...]:
        expr, polarity = first
        return (*self._all_of([first]), *self._all_of([(expr, not polarity), second]))

    def _test(
        self,
        key: tuple[object, ...],
        variables: tuple[int, ...],
        test: Callable[[IndexArrays], Bools],
    ) -> tuple[Condition, ...]:
        """Return the condition that a test holds, or () if it never does; ``key`` identifies it."""
        if key not in self._tests:
            self._tests[key] = self._new_test(variables, test)
        condition = self._tests[key]
        return () if condition is None else (condition,)

    def _new_test(
        self, variables: tuple[int, ...], test: Callable[[IndexArrays], Bools]
    ) -> Condition | None:
        if not variables:
            return ALWAYS if test({}) else None
        if len(variables) > 1:
            return Condition({}, (Factor(variables, test),))
        (variable,) = variables
        size = self.plant.variables[variable].size
        values = np.broadcast_to(test({variable: np.arange(size)}), (size,)).copy()
        return Condition({variable: values}) if values.any() else None

    def values(self, variable: int, chosen: Collection[int]) -> Bools:
        """Return for each value of a state variable whether its index is among the chosen."""
        values = np.zeros(self.plant.variables[variable].size, dtype=np.bool_)
        values[list(chosen)] = True
        return values

    # --- events

    def _stage(
        self,
        event: Event,
        automata: Sequence[LocalAutomaton],
        entry: Condition,
        writes: dict[int, Writes],
    ) -> tuple[tuple[TransitionRule, ...], list[Condition]]:
        merger = Merger()
        range_violations: dict[tuple[object, ...], Condition] = {}
        for options in product(*(self._options(automaton) for automaton in automata)):
            condition: Condition | None = entry
            written = dict(writes)
            for option in options:
                sources = [source for source, _ in option.targets]
                here = Condition({option.variable: self.values(option.variable, sources)})
                condition = condition.both(here) if condition is not None else None
                if any(source != target for source, target in option.targets):
                    written[option.variable] = as_writes(
                        {source: {target} for source, target in option.targets}
                    )
            if condition is not None:
                out = self._choice(event, options, condition, written, merger)
                range_violations.update((one.key(), one) for one in out)
        return merger.rules(), list(range_violations.values())

    def _options(self, automaton: LocalAutomaton) -> list[_Option]:
        edges: dict[int, list[Edge]] = {}
        for edge in automaton.edges:
            edges.setdefault(edge.source, []).append(edge)
        places: dict[
            tuple[tuple[Expr, ...], Expr | None, tuple[tuple[int, Expr], ...]],
            list[tuple[int, int]],
        ] = {}
        for location in range(self.plant.variables[automaton.variable].size):
            fails: tuple[Expr, ...] = ()
            for edge in edges.get(location, ()):
                key = fails, edge.guard, edge.updates
                places.setdefault(key, []).append((location, edge.target))
                if edge.guard is None:
                    break
                fails = (*fails, edge.guard)
            else:
                if not automaton.blocking:
                    places.setdefault((fails, None, ()), []).append((location, location))
        return [_Option(automaton.variable, tuple(t), *key) for key, t in places.items()]

    def _choice(
        self,
        event: Event,
        options: Sequence[_Option],
        entry: Condition,
        writes: dict[int, Writes],
        merger: Merger,
    ) -> Iterator[Condition]:
        """Add the rules of one choice of edges to ``merger``; yield the range violations."""
        free = self._free_writes(event, options)
        options = [
            replace(o, updates=tuple(u for u in o.updates if u[0] not in free)) for o in options
        ]
        writes = {**writes, **free}
        read = [expr for option in options for expr in option.expressions()]
        for chosen in choices(event, read):
            guards = [(holds(g, chosen), False) for o in options for g in o.fails]
            guards += [(holds(o.guard, chosen), True) for o in options if o.guard is not None]
            conditions = _conjoin([entry], self._all_of(guards))
            if not conditions:
                continue
            alternatives: list[tuple[dict[int, Writes], Condition]] = [({}, ALWAYS)]
            for variable, expr in self._updates(options, chosen):
                inside, outside = self._update(variable, expr)
                yield from _conjoin(conditions, outside)
                alternatives = [
                    ({**done, **write}, both)
                    for done, condition in alternatives
                    for write, case in inside
                    if (both := condition.both(case)) is not None
                ]
            for write, case in alternatives:
                for condition in _conjoin(conditions, (case,)):
                    merger.add(condition, {**writes, **write})

    def _free_writes(self, event: Event, options: Sequence[_Option]) -> dict[int, Writes]:
        """Return the writes of parameters that nothing else reads: to any of their values.

        Otherwise all values of such parameters would be combined with each other.
        """
        expressions = [expr for option in options for expr in option.expressions()]
        read = Counter(path for expr in expressions for path in values_read([expr]))
        updates = [update for option in options for update in option.updates]
        written = Counter(variable for variable, _ in updates)
        parameters = {parameter.path: parameter.values for parameter in event.parameters}
        writes: dict[int, Writes] = {}
        for variable, expr in updates:
            if not isinstance(expr, ValueRef) or read[expr.path] > 1 or written[variable] > 1:
                continue
            values, incoming = self.plant.variables[variable].values, parameters[expr.path]
            if any(value is None or value not in values for value in incoming):
                continue
            targets = tuple(sorted({values.index(value) for value in incoming}))
            writes[variable] = ((tuple(range(len(values))), targets),)
        return writes

    def _updates(
        self, options: Sequence[_Option], chosen: PartValues
    ) -> Iterator[tuple[int, Expr]]:
        for option in options:
            before: dict[int, Expr] = {}
            for variable, expr in option.updates:
                old = before.get(variable) or self.plant.leaf_of(self.plant.variables[variable])
                update = assigned(expr, chosen, old)
                if update is not None:
                    before[variable] = update
                    yield variable, update

    def _update(
        self, variable: int, expr: Expr
    ) -> tuple[list[tuple[dict[int, Writes], Condition]], tuple[Condition, ...]]:
        """Return the writes of an update, each with its condition, and the range violations."""
        size = self.plant.variables[variable].size
        everything = tuple(range(size))
        variables = support(self.plant, expr)
        indexes = self._indexes_of(variable, expr)
        if variables == (variable,):
            column = np.arange(size)
            new = np.broadcast_to(indexes({variable: column}), (size,))
            inside = Condition({variable: new >= 0})
            rectangles = as_writes({int(v): {int(new[v])} for v in column if new[v] >= 0})
            outside = (Condition({variable: new < 0}),) if (new < 0).any() else ()
            return ([({variable: rectangles}, inside)] if rectangles else []), outside
        cases: list[tuple[dict[int, Writes], Condition]] = []
        for value in self._possible(variable, variables, indexes):
            conditions = self._index_test(variable, expr, indexes, value)
            write: Writes = ((everything, (value,)),)
            if value >= 0:
                cases.extend(({variable: write}, condition) for condition in conditions)
        return cases, self._index_test(variable, expr, indexes, -1)

    def _indexes_of(self, variable: int, expr: Expr) -> Callable[[IndexArrays], NDArray[Any]]:
        """Return a function for the index of the assigned value, -1 outside the range."""
        values = self.plant.variables[variable].values

        def indexes(columns: IndexArrays) -> NDArray[Any]:
            result = evaluate_vectorised(self.plant, expr, columns)
            if isinstance(values, range):
                outside = (result < values[0]) | (result > values[-1])
                return np.where(outside, -1, result - values[0]).astype(np.int64)
            if isinstance(values, Classes):
                with np.errstate(invalid="ignore"):  # a NaN is compared as well
                    return np.asarray(np.frompyfunc(values.index, 1, 1)(result), dtype=np.int64)
            if isinstance(expr.type, EnumType):
                places = [values.index(name) for name in expr.type.values]
            else:
                places = [values.index(flag) for flag in (False, True)]
            return np.array(places, dtype=np.int64)[result.astype(np.int64)]

        return indexes

    def _possible(
        self,
        variable: int,
        variables: tuple[int, ...],
        indexes: Callable[[IndexArrays], NDArray[Any]],
    ) -> list[int]:
        """Return the indexes that an update can assign; all if computing them is too costly."""
        shape = self.plant.sizes(variables)
        if prod(shape) > _WIDE:
            return list(range(self.plant.variables[variable].size))
        grid = np.ogrid[tuple(map(slice, shape))] if variables else []
        return [int(v) for v in np.unique(indexes(dict(zip(variables, grid, strict=True))))]

    def _index_test(
        self, variable: int, expr: Expr, indexes: Callable[[IndexArrays], NDArray[Any]], value: int
    ) -> tuple[Condition, ...]:
        if isinstance(expr.type, BooleanType) and value >= 0:
            return self.condition(expr, bool(self.plant.variables[variable].values[value]))

        def test(columns: IndexArrays) -> Bools:
            return np.asarray(indexes(columns) == value, dtype=np.bool_)

        return self._test((expr, variable, value), support(self.plant, expr), test)


def _conjoin(conditions: Iterable[Condition], cases: tuple[Condition, ...]) -> list[Condition]:
    return [
        both
        for condition in conditions
        for case in cases
        if (both := condition.both(case)) is not None
    ]
