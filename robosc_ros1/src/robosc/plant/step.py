"""The effect of one event in one state: the reference for engines and generated code."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator
from enum import Enum
from itertools import product
from typing import TypeAlias

from robosc.expr.evaluation import evaluate
from robosc.expr.traversal import all_names
from robosc.expr.tree import Expr, Leaf, ValueRef
from robosc.expr.types import Value
from robosc.language.events import EventKind
from robosc.plant.automaton import Edge, Event, LocalAutomaton, Plant, PlantState
from robosc.runtime.core.values import Undefined

Values: TypeAlias = tuple[Value | None, ...]
"""One value for each parameter of an event."""


class Verdict(Enum):
    IMPOSSIBLE = "impossible"
    """The event is not possible in this state."""
    OUT_OF_RANGE = "out of range"
    """The event would assign a value outside the range of a variable: a controllable event is then
    not possible; a state with such an uncontrollable event must be avoided."""


Outcome: TypeAlias = PlantState | Verdict


def valuations(event: Event) -> Iterator[Values]:
    """Yield the consistent combinations of parameter values; the last parameter varies fastest."""
    pairs = missing_together(event)
    for values in product(*(parameter.values for parameter in event.parameters)):
        if is_consistent(values, pairs):
            yield values


def is_consistent(values: Values, pairs: Iterable[tuple[int, int]]) -> bool:
    """Whether of each pair (:func:`missing_together`) the second is missing if the first is."""
    return not any(values[i] is None and values[j] is not None for i, j in pairs)


def missing_together(event: Event) -> tuple[tuple[int, int], ...]:
    """Return the pairs of parameters (indexes) of which the second is missing if the first is.

    If ``a[1]`` is missing, so are ``a[2]`` and ``a[1].x``. If a part is missing whose path has no
    array, the whole value is.
    """
    parameters = event.parameters
    return tuple(
        (i, j)
        for i, missing in enumerate(parameters)
        for j, other in enumerate(parameters)
        if i != j
        and (
            _needs(other.path, missing.path)
            or (missing.optional and other.optional and all_names(missing.path))
        )
    )


def _needs(path: tuple[str | int, ...], missing: tuple[str | int, ...]) -> bool:
    """Whether a part is missing for sure if the last array element on the path ``missing`` is."""
    depth = max((d for d, step in enumerate(missing) if isinstance(step, int)), default=None)
    if depth is None or len(path) <= depth or path[:depth] != missing[:depth]:
        return False
    last, step = missing[depth], path[depth]
    return isinstance(last, int) and isinstance(step, int) and step >= last


def outcome(plant: Plant, event: Event, values: Values, state: PlantState) -> Outcome:
    """Return the state to which an event leads in the plant, without regard to requirements."""
    if event.phase is not None and state[event.phase.variable] not in event.phase.sources:
        return Verdict.IMPOSSIBLE
    look = lookup(plant, event, values, state)
    after = list(state)
    if event.phase is not None:
        after[event.phase.variable] = event.phase.target
    inside = True
    for automaton in event.automata:
        edge = taken_edge(automaton, state, look)
        if edge is not None:
            inside = _take(plant, edge, automaton, look, after) and inside
        elif automaton.blocking:
            return Verdict.IMPOSSIBLE
    return tuple(after) if inside else Verdict.OUT_OF_RANGE


def is_replacing(event: Event, state: PlantState) -> bool:
    """Whether a request would replace a goal, which is no reason to hold back other commands."""
    phase = event.phase
    return (
        phase is not None
        and event.kind is EventKind.REQUEST
        and state[phase.variable] == phase.target
    )


def holds(plant: Plant, condition: Expr, state: PlantState) -> bool:
    """Whether a condition over the state (a requirement, a guard of the supervisor) is true."""
    return is_true(condition, lookup(plant, None, (), state))


def taken_edge(
    automaton: LocalAutomaton, state: PlantState, look: Callable[[Leaf], Value | None]
) -> Edge | None:
    """Return the edge that an automaton takes in a state; None if no guard holds."""
    location = state[automaton.variable]
    for edge in automaton.edges:
        if edge.source == location and (edge.guard is None or is_true(edge.guard, look)):
            return edge
    return None


def _take(
    plant: Plant,
    edge: Edge,
    automaton: LocalAutomaton,
    look: Callable[[Leaf], Value | None],
    after: list[int],
) -> bool:
    """Apply the updates of an edge to ``after``; False if a variable would leave its range."""
    after[automaton.variable] = edge.target
    inside = True
    for variable, expr in edge.updates:
        try:
            value = evaluate(expr, look)
        except Undefined:
            continue
        values = plant.variables[variable].values
        if value in values:
            after[variable] = values.index(value)
        else:
            inside = False
    return inside


def is_true(condition: Expr, look: Callable[[Leaf], Value | None]) -> bool:
    """Whether a condition holds; one that is undefined does not."""
    try:
        return evaluate(condition, look) is True
    except Undefined:
        return False


def lookup(
    plant: Plant, event: Event | None, values: Values, state: PlantState
) -> Callable[[Leaf], Value | None]:
    """Return a function from leaves of expressions to their values in a state and an event."""
    taken = {p.path: v for p, v in zip(event.parameters, values, strict=True)} if event else {}

    def look(leaf: Leaf) -> Value | None:
        if isinstance(leaf, ValueRef):
            return taken[leaf.path]
        variable = plant.variable_of(leaf)
        assert variable is not None, "only aggregates and tests read this leaf"
        return plant.variables[variable].read(leaf, state[variable])

    return look
