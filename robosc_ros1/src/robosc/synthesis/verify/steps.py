"""Single steps of a plant for the explicit verifier: the successors by one event in one state.

A state is coded as one integer, its state variables in mixed radix, so that a step is an addition.
The effect of an event (:func:`robosc.plant.step.outcome`) and the value of a condition depend on
few state variables; they are computed once for each combination of their values and cached.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from dataclasses import replace
from functools import cache, partial
from math import prod
from operator import itemgetter
from typing import Any, TypeAlias, TypeVar

from robosc import limits
from robosc.errors import StateSpaceError
from robosc.expr.tree import Binary, Expr, Unary
from robosc.plant.automaton import Event, Plant, PlantState
from robosc.plant.step import Verdict, holds, outcome, valuations
from robosc.plant.support import support

T = TypeVar("T")

Condition: TypeAlias = Callable[[PlantState], bool]

Successors: TypeAlias = tuple[tuple[int, int | None], ...]
"""Per combination of values of the event: its number, and what is added to the state's code; None
if an assignment would leave its range.
"""

_CHUNK = 4096  # combinations of state variables in one cache
_WIDE = 2**16  # combinations of what a condition reads, of which some are cached


class Coding:
    """States as integers; the last state variable varies fastest."""

    def __init__(self, plant: Plant) -> None:
        sizes = [variable.size for variable in plant.variables]
        self._strides = [prod(sizes[i + 1 :]) for i in range(len(sizes))]
        # State variables are decoded in runs; each has its product of sizes, and a cache.
        runs: list[list[int]] = [[]]
        for size in reversed(sizes):
            if runs[-1] and prod(runs[-1]) * size > _CHUNK:
                runs.append([])
            runs[-1].insert(0, size)
        self._runs = [(prod(run), cache(partial(_digits, run))) for run in runs]

    def encode(self, state: PlantState) -> int:
        return sum(value * stride for value, stride in zip(state, self._strides, strict=True))

    def decode(self, code: int) -> PlantState:
        state: PlantState = ()
        for total, digits in self._runs:
            code, part = divmod(code, total)
            state = digits(part) + state
        return state


def _digits(sizes: Sequence[int], number: int) -> PlantState:
    digits = []
    for size in reversed(sizes):
        number, digit = divmod(number, size)
        digits.append(digit)
    return tuple(reversed(digits))


# --- caches --------------------------------------------------------------------------------------


def _size(plant: Plant, variables: Iterable[int]) -> int:
    return prod(plant.variables[variable].size for variable in variables)


def _cached(variables: Iterable[int], of: Callable[[PlantState], T]) -> Callable[[PlantState], T]:
    """Return a function of the state that depends on some state variables only, with a cache."""
    chosen = sorted(variables)
    key: Callable[[PlantState], Any] = itemgetter(*chosen) if chosen else lambda state: ()
    known: dict[Any, T] = {}

    def cached(state: PlantState) -> T:
        here = key(state)
        try:
            return known[here]
        except KeyError:
            found = of(state)
            if len(known) < _CHUNK:
                known[here] = found
            return found

    return cached


def condition(plant: Plant, expr: Expr) -> Condition:
    """Return a function that evaluates a condition over the state.

    Results are cached by the values that it reads, if there are not very many combinations; a wide
    condition is decomposed at its operators.
    """
    variables = support(plant, expr)
    size = _size(plant, variables)
    parts = None if size <= _CHUNK else _decomposed(plant, expr)
    if parts is not None and size > _WIDE:
        return parts
    return _cached(variables, parts or partial(holds, plant, expr))


def _decomposed(plant: Plant, expr: Expr) -> Condition | None:
    match expr:
        case Unary(operator="!", operand=operand):
            inner = condition(plant, operand)
            return lambda state: not inner(state)
        case Binary(operation=operation, left=left, right=right) if operation.is_lazy:
            first, second = condition(plant, left), condition(plant, right)
            decider, decided = operation.decider, operation.decided
            return lambda state: decided if first(state) is decider else second(state)
    return None


def grouped(
    plant: Plant,
    events: Iterable[tuple[int, set[int]]],
    work_out: Callable[[int, PlantState], T | None],
) -> Callable[[PlantState], list[T]]:
    """Return the function of the state that returns the results of events; None is left out.

    Each event comes with the state variables on which its result depends. Events that together
    depend on few share one cache, so a state costs one look-up per group. An event that depends on
    many is evaluated anew in each state.
    """

    def results(events: Iterable[int], state: PlantState) -> list[T]:
        found = (work_out(event, state) for event in events)
        return [result for result in found if result is not None]

    groups: list[tuple[set[int], list[int]]] = [(set(), [])]
    wide: list[int] = []
    for event, variables in events:
        if _size(plant, variables) > _CHUNK:
            wide.append(event)
            continue
        if _size(plant, groups[-1][0] | variables) > _CHUNK:
            groups.append((set(), []))
        groups[-1][0].update(variables)
        groups[-1][1].append(event)
    functions = [_cached(shared, partial(results, group)) for shared, group in groups]
    if wide:
        functions.append(partial(results, wide))
    return lambda state: [result for function in functions for result in function(state)]


# --- events --------------------------------------------------------------------------------------


def read_by(plant: Plant, event: Event) -> set[int]:
    """Return the state variables on which the effect of an event depends."""
    read = set() if event.phase is None else {event.phase.variable}
    for automaton in event.automata:
        read.add(automaton.variable)
        read.update(*(support(plant, expr) for expr in automaton.expressions))
    return read


class EventSteps:
    """The successors by one event, cached by the state variables that it reads and writes.

    Automata that share an event change variables of their own, and read all values before it. One
    that reads and writes many variables is therefore taken apart, and what each of its automata
    does is cached: blocks of a track that wait for one vehicle.
    """

    def __init__(self, plant: Plant, coding: Coding, event: Event) -> None:
        self.event = event
        if prod(len(p.values) for p in event.parameters) > limits.VERIFIED_VALUES:
            raise StateSpaceError(
                f"verification stops at {limits.VERIFIED_VALUES} combinations of the parts"
                f" of a value; {event.name} has more"
            )
        self.valuations = tuple(valuations(event))
        self.variables = read_by(plant, event) | event.writes
        self._plant = plant
        self._coding = coding
        self._parts: list[Callable[[PlantState], list[int | Verdict]]]
        self._parts = [partial(self._changes, event)]
        self.successors: Callable[[PlantState], Successors] = self._computed
        if _size(plant, self.variables) <= _CHUNK:
            self.successors = _cached(self.variables, self._computed)
            return
        own = [replace(event, automata=(each,), phase=None) for each in event.automata]
        self._parts = [
            _cached(read_by(plant, part) | part.writes, partial(self._changes, part))
            for part in (replace(event, automata=()), *own)
        ]

    def _computed(self, state: PlantState) -> Successors:
        """Return the successors by the event; none if the plant cannot do it."""
        found: list[tuple[int, int | None]] = []
        for number, changes in enumerate(zip(*(part(state) for part in self._parts), strict=True)):
            inside = [change for change in changes if not isinstance(change, Verdict)]
            if len(inside) == len(changes):
                found.append((number, sum(inside)))
            elif Verdict.IMPOSSIBLE not in changes and not self.event.controllable:
                found.append((number, None))
        return tuple(found)

    def _changes(self, part: Event, state: PlantState) -> list[int | Verdict]:
        """Return what a part of the event adds to the state's code, by combination of values."""
        here = self._coding.encode(state)
        outcomes = (outcome(self._plant, part, values, state) for values in self.valuations)
        return [
            after if isinstance(after, Verdict) else self._coding.encode(after) - here
            for after in outcomes
        ]
