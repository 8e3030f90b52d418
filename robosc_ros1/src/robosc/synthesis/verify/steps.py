"""Single steps of a plant for the independent verifier: the effect of an event in one state.

A state is coded as one integer, its state variables in mixed radix, so that a step is an addition.
The effect of an event depends on few state variables; it is computed as defined in
:mod:`robosc.ir.automaton` once for each combination of their values and cached.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator
from itertools import product
from math import prod
from operator import itemgetter
from typing import Any, Generic, TypeAlias, TypeVar

from robosc.errors import StateSpaceError
from robosc.ir.automaton import Edge, Event, LocalAutomaton, Plant, PlantState, VariableKind
from robosc.ir.formulas import Leaf, Undefined, evaluate
from robosc.model.expr import (
    Binary,
    ElementRef,
    Expr,
    ParameterRef,
    PhaseRef,
    StateRef,
    TestRef,
    Unary,
    ValueRef,
    VariableRef,
)
from robosc.model.traversal import walk
from robosc.model.types import Value

__all__ = [
    "Coding",
    "Condition",
    "EventSteps",
    "Grouped",
    "Successors",
    "variables_of",
    "variables_read",
    "condition",
    "value_in",
    "values_read",
]

T = TypeVar("T")

Condition: TypeAlias = Callable[[PlantState], bool]

Successors: TypeAlias = tuple[tuple[int, int | None], ...]
"""Per combination of values of the event: its number, and what is added to the state's code; None
if an assignment would leave its range.
"""

_Values: TypeAlias = tuple[Value | None, ...]
_Parameters: TypeAlias = dict[tuple[str | int, ...], Value | None]
_MOST_VALUES = 1 << 22
_CHUNK = 4096  # combinations of state variables in one cache


class Coding:
    """States as integers; the last state variable varies fastest."""

    def __init__(self, plant: Plant) -> None:
        sizes = [variable.size for variable in plant.variables]
        self.strides = [prod(sizes[i + 1 :]) for i in range(len(sizes))]
        # State variables are decoded in runs; each has its product of sizes, and a cache.
        self._runs: list[tuple[int, list[int], dict[int, PlantState]]] = []
        run: list[int] = []
        for size in reversed(sizes):
            if run and prod(run) * size > _CHUNK:
                self._runs.append((prod(run), run, {}))
                run = []
            run = [size, *run]
        self._runs.append((prod(run), run, {}))

    def encode(self, state: PlantState) -> int:
        return sum(value * stride for value, stride in zip(state, self.strides, strict=True))

    def decode(self, code: int) -> PlantState:
        state: PlantState = ()
        for total, sizes, known in self._runs:
            code, part = divmod(code, total)
            values = known.get(part)
            if values is None:
                values = known[part] = _digits(part, sizes)
            state = values + state
        return state


def _digits(number: int, sizes: list[int]) -> PlantState:
    digits = []
    for size in reversed(sizes):
        number, digit = divmod(number, size)
        digits.append(digit)
    return tuple(reversed(digits))


def _size(plant: Plant, variables: Iterable[int]) -> int:
    return prod(plant.variables[variable].size for variable in variables)


def _getter(variables: Iterable[int]) -> Callable[[PlantState], Any]:
    chosen = sorted(variables)
    return itemgetter(*chosen) if chosen else lambda state: ()


def condition(plant: Plant, expr: Expr) -> Condition:
    """Return a function that evaluates a condition over the state.

    If it reads few state variables, results are cached by their values; a wider condition is
    decomposed at its operators.
    """
    variables = variables_of(plant, expr)
    if _size(plant, variables) > _CHUNK:
        match expr:
            case Unary(operator="!", operand=operand):
                inner = condition(plant, operand)
                return lambda state: not inner(state)
            case Binary(operator="and" | "or" | "=>" as operator, left=left, right=right):
                first, second = condition(plant, left), condition(plant, right)
                if operator == "and":
                    return lambda state: first(state) and second(state)
                if operator == "or":
                    return lambda state: first(state) or second(state)
                return lambda state: not first(state) or second(state)
    key, known = _getter(variables), dict[Any, bool]()

    def remembered(state: PlantState) -> bool:
        here = key(state)
        found = known.get(here)
        if found is None:
            found = known[here] = _holds(plant, expr, state, {})
        return found

    return remembered


class Grouped(Generic[T]):
    """A function of event and state, cached for groups of events; results of None are left out.

    Events that together depend on few state variables share one cache, so a state costs one look-up
    per group. An event that depends on many is evaluated anew in each state.
    """

    def __init__(
        self,
        plant: Plant,
        events: Iterable[tuple[int, set[int]]],
        work_out: Callable[[int, PlantState], T | None],
    ) -> None:
        self._work_out = work_out
        self._groups: list[tuple[Callable[[PlantState], Any], list[int], dict[Any, list[T]]]] = []
        self._wide: list[int] = []
        group: list[int] = []
        shared: set[int] = set()
        for event, variables in events:
            if _size(plant, variables) > _CHUNK:
                self._wide.append(event)
                continue
            if _size(plant, shared | variables) > _CHUNK:
                self._groups.append((_getter(shared), group, {}))
                group, shared = [], set()
            group.append(event)
            shared |= variables
        self._groups.append((_getter(shared), group, {}))

    def __call__(self, state: PlantState) -> Iterator[T]:
        for key, events, known in self._groups:
            here = key(state)
            found = known.get(here)
            if found is None:
                found = known[here] = list(self._results(events, state))
            yield from found
        if self._wide:
            yield from self._results(self._wide, state)

    def _results(self, events: Iterable[int], state: PlantState) -> Iterator[T]:
        for event in events:
            result = self._work_out(event, state)
            if result is not None:
                yield result


class EventSteps:
    """The effect of one event, cached by the state variables that it reads and writes."""

    def __init__(self, plant: Plant, coding: Coding, event: Event) -> None:
        self.event = event
        if prod(len(p.values) for p in event.parameters) > _MOST_VALUES:
            raise StateSpaceError(
                f"verification stops at {_MOST_VALUES} combinations of the parts of a value;"
                f" {event.name} has more"
            )
        self.valuations = [
            v for v in product(*(p.values for p in event.parameters)) if _fit(event, v)
        ]
        self.variables = _touched(plant, event)
        self._plant = plant
        self._coding = coding
        self._few = _size(plant, self.variables) <= _CHUNK
        self._key = _getter(self.variables)
        self._known: dict[Any, Successors] = {}

    def __call__(self, state: PlantState) -> Successors:
        """Return the successors by the event; none if the plant cannot do it."""
        if not self._few:
            return tuple(self._moves(state))
        here = self._key(state)
        found = self._known.get(here)
        if found is None:
            found = self._known[here] = tuple(self._moves(state))
        return found

    def _moves(self, state: PlantState) -> Iterator[tuple[int, int | None]]:
        here = self._coding.encode(state)
        for number, values in enumerate(self.valuations):
            after = self.after(state, values)
            if isinstance(after, list):
                yield number, self._coding.encode(tuple(after)) - here
            elif after == "escapes" and not self.event.controllable:
                yield number, None

    def after(self, state: PlantState, values: _Values) -> list[int] | str:
        """Return the state after the event with some values, ``impossible`` or ``escapes``."""
        after = list(state)
        phase = self.event.phase
        if phase is not None:
            if state[phase.variable] not in phase.sources:
                return "impossible"
            after[phase.variable] = phase.target
        parameters = dict(zip((p.path for p in self.event.parameters), values, strict=True))
        escapes = False
        for automaton in self.event.automata:
            edge = self._edge(automaton, state, parameters)
            if edge is None:
                if automaton.blocking:
                    return "impossible"
                continue
            after[automaton.variable] = edge.target
            escapes |= not self._assign(edge, state, parameters, after)
        return "escapes" if escapes else after

    def _edge(
        self, automaton: LocalAutomaton, state: PlantState, parameters: _Parameters
    ) -> Edge | None:
        for edge in automaton.edges:
            if edge.source == state[automaton.variable] and (
                edge.guard is None or _holds(self._plant, edge.guard, state, parameters)
            ):
                return edge
        return None

    def _assign(
        self, edge: Edge, state: PlantState, parameters: _Parameters, after: list[int]
    ) -> bool:
        """Assign to ``after``; whether all stay in range. An undefined value changes nothing."""
        for variable, expr in edge.updates:
            try:
                value = evaluate(expr, _lookup(self._plant, state, parameters))
            except Undefined:
                continue
            values = self._plant.variables[variable].values
            if value not in values:
                return False
            after[variable] = values.index(value)
        return True


def _fit(event: Event, values: _Values) -> bool:
    """Whether an event can have these parameter values.

    If an array element is missing, so are all that follow it and everything inside them. What is
    not inside an array is missing only with the whole value, as when an action fails without a
    result.
    """
    there = [p for p, v in zip(event.parameters, values, strict=True) if v is not None]
    for parameter, value in zip(event.parameters, values, strict=True):
        if value is None and parameter.test is None:
            missing = parameter.path
            at = max((i for i, step in enumerate(missing) if isinstance(step, int)), default=None)
            if at is None:
                if any(other.optional for other in there):
                    return False
                continue
            first = missing[at]
            assert isinstance(first, int)
            for path in (other.path for other in there):
                step = path[at] if path[:at] == missing[:at] and len(path) > at else None
                if isinstance(step, int) and step >= first:
                    return False
    return True


def _lookup(
    plant: Plant, state: PlantState, parameters: _Parameters
) -> Callable[[Leaf], Value | None]:
    def look(leaf: Leaf) -> Value | None:
        if isinstance(leaf, ValueRef):
            return parameters[leaf.path]
        assert not isinstance(leaf, ElementRef | ParameterRef)
        variable = _variable_of(plant, leaf)
        value = plant.variables[variable].values[state[variable]]
        if isinstance(leaf, StateRef):
            return value == leaf.state
        return value == leaf.phase if isinstance(leaf, PhaseRef) else value

    return look


def _variable_of(plant: Plant, leaf: VariableRef | TestRef | StateRef | PhaseRef) -> int:
    match leaf:
        case TestRef(name=name):
            return plant.variable_index[VariableKind.TEST, name]
        case VariableRef(component=component, variable=variable):
            return plant.variable_index[VariableKind.DATA, f"{component}.{variable}"]
        case StateRef(component=component):
            return plant.variable_index[VariableKind.LOCATION, component]
    return plant.variable_index[VariableKind.PHASE, leaf.communication]


def variables_of(plant: Plant, expr: Expr) -> set[int]:
    """Return the state variables that an expression reads."""
    return {
        _variable_of(plant, part)
        for part in walk(expr)
        if isinstance(part, VariableRef | TestRef | StateRef | PhaseRef)
    }


def value_in(plant: Plant, expr: Expr, state: PlantState) -> Value:
    """Return the value of an expression; a condition that reads a missing element is false."""
    try:
        return evaluate(expr, _lookup(plant, state, {}))
    except Undefined:
        return False


def values_read(event: Event) -> set[tuple[str | int, ...]]:
    """Return the paths of the parameters that an event's automata read."""
    read = (expr for automaton in event.automata for expr in automaton.expressions)
    return {part.path for expr in read for part in walk(expr) if isinstance(part, ValueRef)}


def variables_read(plant: Plant, event: Event) -> set[int]:
    """Return the state variables on which the effect of an event depends."""
    variables = set() if event.phase is None else {event.phase.variable}
    for automaton in event.automata:
        variables.add(automaton.variable)
        variables.update(*(variables_of(plant, expr) for expr in automaton.expressions))
    return variables


def _touched(plant: Plant, event: Event) -> set[int]:
    edges = (edge for automaton in event.automata for edge in automaton.edges)
    return variables_read(plant, event).union(
        variable for edge in edges for variable, _ in edge.updates
    )


def _holds(plant: Plant, expr: Expr, state: PlantState, parameters: _Parameters) -> bool:
    """Whether a condition holds; one that reads a missing element does not."""
    try:
        return bool(evaluate(expr, _lookup(plant, state, parameters)))
    except Undefined:
        return False
