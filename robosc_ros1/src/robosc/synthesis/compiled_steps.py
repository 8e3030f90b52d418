"""Single steps of a plant, compiled: :func:`robosc.plant.step.outcome` as Python functions.

State-by-state search evaluates every event with every value in every state, so each event is
compiled into one function of the state and the values, both tuples.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from functools import cache, cached_property, partial
from typing import Any, TypeAlias

from robosc.expr.evaluation import converted
from robosc.expr.traversal import walk
from robosc.expr.tree import (
    TRUE,
    ElementRef,
    Expr,
    Leaf,
    ParameterRef,
    PhaseRef,
    StateRef,
    TestRef,
    ValueRef,
    VariableRef,
)
from robosc.expr.types import EnumType
from robosc.language.functions import HELPERS
from robosc.lazy_dataclasses import dataclass
from robosc.plant.automaton import Edge, Event, LocalAutomaton, Plant, PlantState
from robosc.plant.data.classes import Classes
from robosc.plant.python_text import to_python
from robosc.plant.step import Outcome, Values, Verdict, is_consistent, missing_together, valuations
from robosc.runtime.core.values import Undefined
from robosc.supervisor import Guard
from robosc.synthesis.event_parameters import weight

_MOST_KEPT = 2**16
"""Combinations of parameter values that are stored; more are enumerated anew each time."""

StepFunction: TypeAlias = Callable[[PlantState, Values], Outcome]
Test: TypeAlias = Callable[[PlantState], bool]
_Slots: TypeAlias = Mapping[tuple[str | int, ...], tuple[int, bool]]
"""The place of each part of the value, and whether it may be missing."""


@dataclass(frozen=True, slots=True)
class CompiledEvent:
    """An event compiled for evaluation in many states; ``number`` is its index in the plant.

    ``test`` is the condition under which it may happen; None: always.
    """

    number: int
    test: Test | None
    values: Iterable[Values]
    step: StepFunction

    def targets(self, state: PlantState) -> Iterator[tuple[Values, PlantState]]:
        """Yield the values with which the event is possible, each with the state it leads to."""
        return self._targets(state, self.values)

    def some_targets(self, state: PlantState) -> Iterator[tuple[Values, PlantState]]:
        """The same, for a sample of the combinations if there are too many."""
        return self._targets(state, self.some_values)

    def _targets(
        self, state: PlantState, tried: Iterable[Values]
    ) -> Iterator[tuple[Values, PlantState]]:
        if self.test is not None and not self.test(state):
            return
        for values in tried:
            after = self.step(state, values)
            if not isinstance(after, Verdict):
                yield values, after

    @property
    def is_sampled(self) -> bool:
        """Whether there are too many combinations of values to try them all."""
        return isinstance(self.values, _Valuations)

    @property
    def some_values(self) -> Iterable[Values]:
        """All combinations of values, or a sample if there are too many."""
        return self.values.sample() if isinstance(self.values, _Valuations) else self.values

    def leading(self, state: PlantState, target: PlantState) -> Values | None:
        """Return values with which the event leads from a state to the target, if any is found.

        If the event is sampled, such values may exist nevertheless.
        """
        if self.test is not None and not self.test(state):
            return None
        if isinstance(self.values, _Valuations):
            return self.values.nearest(lambda one: _differences(self.step(state, one), target))
        return next((values for values in self.values if self.step(state, values) == target), None)


class _Valuations:
    """The combinations of an event's values, enumerated anew on each iteration."""

    def __init__(self, event: Event) -> None:
        self.event = event
        self._pairs = missing_together(event)

    def __iter__(self) -> Iterator[Values]:
        return valuations(self.event)

    def nearest(self, distance: Callable[[Values], float]) -> Values | None:
        """Return values at distance 0 by greedy local search; None at a local minimum."""
        for one in self._bases():
            least = distance(one)
            for number in range(len(one)):
                for other in self._changed(one, number):
                    if (far := distance(other)) < least:
                        one, least = other, far
            if least == 0:
                return one
        return None

    def sample(self) -> Iterator[Values]:
        """Yield the combinations in which all parameters but two have their first or last value."""
        for base in self._bases():
            yield base
            for first in range(len(base)):
                for one in self._changed(base, first):
                    yield one
                    for second in range(first):
                        yield from self._changed(one, second)

    def _bases(self) -> Iterator[Values]:
        """Yield the combinations of all first and of all last values."""
        for place in (0, -1):
            yield tuple(p.values[place] for p in self.event.parameters)

    def _changed(self, values: Values, number: int) -> Iterator[Values]:
        """Yield the consistent combinations that differ in one parameter."""
        for value in self.event.parameters[number].values:
            other = (*values[:number], value, *values[number + 1 :])
            if value != values[number] and is_consistent(other, self._pairs):
                yield other


def _differences(after: Outcome, target: PlantState) -> float:
    """Return in how many variables two states differ; infinity if the step is not possible."""
    if isinstance(after, Verdict):
        return math.inf
    return sum(a != b for a, b in zip(after, target, strict=True))


class Stepper:
    """Steps of a plant and conditions over its states, compiled to Python functions on demand."""

    def __init__(self, plant: Plant) -> None:
        self.plant = plant
        self._namespace: dict[str, Any] = {
            **HELPERS,
            "Undefined": Undefined,
            "need": _need,
            "inf": math.inf,
            "nan": math.nan,
            "IMPOSSIBLE": Verdict.IMPOSSIBLE,
            "OUT_OF_RANGE": Verdict.OUT_OF_RANGE,
        }
        for number, variable in enumerate(plant.variables):
            if not isinstance(variable.values, range):
                self._namespace[f"V{number}"] = tuple(variable.values)
                self._namespace[f"I{number}"] = {v: i for i, v in enumerate(variable.values)}
            if isinstance(variable.values, Classes):
                self._namespace[f"class{number}"] = cache(variable.values.index)
        self._steps: dict[int, StepFunction] = {}
        self._tests: dict[Expr, Test] = {}
        self._values: dict[int, Iterable[Values]] = {}

    @cached_property
    def order(self) -> Sequence[int]:
        """The events in the order in which one that leads on is looked for: commands with several
        outcomes come last, as one may be disabled though it could lead there."""
        events = self.plant.events
        return sorted(range(len(events)), key=lambda number: events[number].branches)

    @cached_property
    def writing(self) -> Sequence[Sequence[int]]:
        """Per state variable the events that write it, in this order."""
        found: list[list[int]] = [[] for _ in self.plant.variables]
        for number in self.order:
            for variable in self.plant.events[number].writes:
                found[variable].append(number)
        return found

    def outcome(self, event: int, values: Values, state: PlantState) -> Outcome:
        """Return where an event leads in the plant without its requirements."""
        return self.step(event)(state, values)

    def step(self, event: int) -> StepFunction:
        """Return an event as a function of the state and the values."""
        found = self._steps.get(event)
        if found is None:
            found = self._steps[event] = self._compile_event(self.plant.events[event])
        return found

    def holds(self, condition: Expr, state: PlantState) -> bool:
        """Whether a condition over the state is true."""
        return self.test(condition)(state)

    def test(self, condition: Expr) -> Test:
        """Return a condition as a function of the state."""
        found = self._tests.get(condition)
        if found is None:
            text = self._python(condition, {})
            found = self._define(f"lambda s: bool({text})")
            self._tests[condition] = found
        return found

    def every(self, conditions: Iterable[Expr]) -> Test:
        """Return as a function of the state whether all conditions are true."""
        text = " and ".join(f"({self._python(condition, {})})" for condition in conditions)
        test: Test = self._define(f"lambda s: bool({text or True})")
        return test

    def compiled(self, event: int, condition: Expr | None) -> CompiledEvent:
        """Return an event with all its values, restricted to a condition (None: always)."""
        if condition is None or condition == TRUE:
            test = None
        else:
            test = self.test(condition)
        return CompiledEvent(event, test, self._values_of(event), self.step(event))

    def _values_of(self, event: int) -> Iterable[Values]:
        """Return the values of an event, stored unless there are very many."""
        values = self._values.get(event)
        if values is None:
            taken = self.plant.events[event]
            few = weight(taken) <= _MOST_KEPT
            values = self._values[event] = tuple(valuations(taken)) if few else _Valuations(taken)
        return values

    def controlled(self, guards: Iterable[Guard]) -> list[CompiledEvent]:
        """Return all events of the plant under a supervisor, in model order."""
        allowed = {guard.event.identity: guard.expr for guard in guards}
        events = enumerate(self.plant.events)
        return [self.compiled(n, allowed.get(event.identity)) for n, event in events]

    def required(self) -> tuple[CompiledEvent, ...]:
        """Return all events of the plant under its requirements, in model order."""
        return tuple(self.compiled(n, e.requirement) for n, e in enumerate(self.plant.events))

    def _define(self, text: str) -> Any:
        return eval(text, self._namespace)

    def _compile_event(self, event: Event) -> StepFunction:
        lines = list(self._event_lines(event))
        scope = dict(self._namespace)
        exec("def step(s, v):\n" + "".join(f"    {line}\n" for line in lines), scope)
        step: StepFunction = scope["step"]
        return step

    def _event_lines(self, event: Event) -> Iterator[str]:
        if event.phase is not None:
            sources = event.phase.sources
            yield f"if s[{event.phase.variable}] not in {sources}: return IMPOSSIBLE"
        yield "t = list(s)"
        yield "inside = True"
        if event.phase is not None:
            yield f"t[{event.phase.variable}] = {event.phase.target}"
        slots = {p.path: (i, None in p.values) for i, p in enumerate(event.parameters)}
        for automaton in event.automata:
            yield from self._automaton_lines(automaton, slots)
        yield "return tuple(t) if inside else OUT_OF_RANGE"

    def _automaton_lines(self, automaton: LocalAutomaton, slots: _Slots) -> Iterator[str]:
        yield "while True:"
        for edge in automaton.edges:
            yield f"    if s[{automaton.variable}] == {edge.source}:"
            indent = " " * 8
            if edge.guard is not None:
                text = self._python(edge.guard, slots)
                yield f"{indent}try: holds = {text}"
                yield f"{indent}except Undefined: holds = False"
                yield f"{indent}if holds:"
                indent += " " * 4
            for line in self._edge_lines(automaton, edge, slots):
                yield indent + line
        yield "    return IMPOSSIBLE" if automaton.blocking else "    break"

    def _edge_lines(
        self,
        automaton: LocalAutomaton,
        edge: Edge,
        slots: _Slots,
    ) -> Iterator[str]:
        yield f"t[{automaton.variable}] = {edge.target}"
        for variable, expr in edge.updates:
            text = self._python(expr, slots)
            undefined = any(isinstance(n, ValueRef) and slots[n.path][1] for n in walk(expr))
            indent = ""
            if undefined:
                yield "try:"
                indent = " " * 4
            yield f"{indent}x = {text}"
            values = self.plant.variables[variable].values
            if isinstance(values, Classes):
                yield f"{indent}t[{variable}] = class{variable}(x)"
            elif isinstance(values, range):
                low, high = values[0], values[-1]
                yield f"{indent}if {low} <= x <= {high}: t[{variable}] = x - {low}"
                yield f"{indent}else: inside = False"
            else:
                yield f"{indent}if x in I{variable}: t[{variable}] = I{variable}[x]"
                yield f"{indent}else: inside = False"
            if undefined:
                yield "except Undefined: pass"
        yield "break"

    def _python(self, expr: Expr, slots: _Slots) -> str:
        return to_python(expr, lambda leaf: self._leaf(leaf, slots), convert=self._converted)

    def _converted(self, enum: EnumType, text: str) -> str:
        name = f"E_{enum.origin}_{enum.name}"
        self._namespace[name] = cache(partial(converted, enum))
        return f"{name}({text})"

    def _leaf(self, leaf: Leaf, slots: _Slots) -> str:
        if isinstance(leaf, ValueRef):
            slot, undefined = slots[leaf.path]
            return f"need(v[{slot}])" if undefined else f"v[{slot}]"
        variable = self.plant.variable_of(leaf)
        assert variable is not None
        match leaf:
            case StateRef(places=names) | PhaseRef(places=names):
                indexes = [self.plant.variables[variable].values.index(name) for name in names]
                test = f"== {indexes[0]}" if len(indexes) == 1 else f"in {tuple(indexes)}"
                return f"(s[{variable}] {test})"
            case VariableRef() | TestRef():
                values = self.plant.variables[variable].values
                if isinstance(values, range):
                    return f"(s[{variable}] + {values[0]})" if values[0] else f"s[{variable}]"
                return f"V{variable}[s[{variable}]]"
            case ElementRef() | ParameterRef():
                raise AssertionError("it belongs to an aggregate, or to a test")


def _need(value: Any) -> Any:
    if value is None:
        raise Undefined
    return value
