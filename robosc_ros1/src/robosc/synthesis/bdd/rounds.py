"""When a plant's state variables can first change, which decides the direction of their order.

Saturation closes a set under what lies further down in the order before it goes on above. Where
parts of a plant pass something on to others, those that pass it on should lie below those that
wait for it: from above, each piece that they pass on lets the parts below reach a little more, and
these are closed anew for each: five times slower on four cells of three (``published_families``).

How early a variable can change is estimated in rounds. In each, all transitions are taken that
nothing forbids but variables that still have their initial values; of a location and of a phase it
counts which values they can have had, of data only that they can have changed.
"""

from __future__ import annotations

from collections.abc import Collection, Iterator, Mapping, Sequence
from typing import TypeAlias

from robosc.expr.evaluation import evaluate
from robosc.expr.traversal import operands, walk
from robosc.expr.tree import Expr, Leaf, ValueRef
from robosc.expr.types import Value
from robosc.lazy_dataclasses import dataclass
from robosc.plant.automaton import Edge, Event, LocalAutomaton, Plant, VariableKind
from robosc.plant.support import support
from robosc.runtime.core.values import Undefined
from robosc.synthesis.bdd.sources import LeafSource

_Fact: TypeAlias = tuple[int, int]
"""A state variable and the index of a value; -1 for data that have changed."""
_Needs: TypeAlias = list[frozenset[_Fact]]
"""Sets of facts of which each must contain one."""

_LEAST_SLOPE = 0.05
"""Rounds per place in the order below which it has no direction; measured are 0.08 and more."""


@dataclass(frozen=True, slots=True)
class _Move:
    """What a part of an event writes; of each of the ``choices`` one must be met."""

    choices: tuple[tuple[_Needs, ...], ...]
    writes: frozenset[_Fact]

    def possible(self, facts: Collection[_Fact]) -> bool:
        return all(
            any(not any(one.isdisjoint(facts) for one in needs) for needs in choice)
            for choice in self.choices
        )


def early_last(plant: Plant, order: Sequence[LeafSource]) -> Sequence[LeafSource]:
    """Return an order, or its reverse if the variables that change early would come first."""
    rounds = first_rounds(plant)
    found = [rounds[item] for item in order if isinstance(item, int) and item in rounds]
    middle = (len(found) - 1) / 2
    together = sum((place - middle) * number for place, number in enumerate(found))
    spread = sum((place - middle) ** 2 for place in range(len(found)))
    return order[::-1] if together > _LEAST_SLOPE * spread else order


def first_rounds(plant: Plant) -> dict[int, int]:
    """Return, by state variable, the round in which it can first change; some never do."""
    found: dict[int, int] = {}
    facts: set[_Fact] = set()
    waiting = [move for event in plant.events for move in _moves(plant, event)]
    number = 0
    while True:
        number += 1
        possible = [move.possible(facts) for move in waiting]
        if not any(possible):
            return found
        for move, now in zip(waiting, possible, strict=True):
            if now:
                facts |= move.writes
                for variable, _ in move.writes:
                    found.setdefault(variable, number)
        waiting = [move for move, now in zip(waiting, possible, strict=True) if not now]


def _moves(plant: Plant, event: Event) -> Iterator[_Move]:
    """Yield what an event does to its communication, and what each edge does."""
    own = list(_unmet(plant, event.requirement))
    phase = event.phase
    if phase is not None and plant.initial[phase.variable] not in phase.sources:
        own.append(frozenset((phase.variable, source) for source in phase.sources))
    edges = [[_edge_needs(plant, a, edge) for edge in a.edges] for a in event.automata]
    blocking = [tuple(of) for a, of in zip(event.automata, edges, strict=True) if a.blocking]
    together = ((own,), *blocking)
    if phase is not None:
        yield _Move(together, frozenset([(phase.variable, phase.target)]))
    for automaton, of in zip(event.automata, edges, strict=True):
        for edge, needs in zip(automaton.edges, of, strict=True):
            writes = {(variable, -1) for variable, _ in edge.updates}
            if edge.target != edge.source:
                writes.add((automaton.variable, edge.target))
            yield _Move((*together, (needs,)), frozenset(writes))


def _edge_needs(plant: Plant, automaton: LocalAutomaton, edge: Edge) -> _Needs:
    found = list(_unmet(plant, edge.guard))
    if plant.initial[automaton.variable] != edge.source:
        found.append(frozenset([(automaton.variable, edge.source)]))
    for variable, expr in edge.updates:
        values = plant.variables[variable].values
        if not _reads_event(expr) and _value(plant, expr) not in values:
            found.append(_facts(plant, support(plant, expr)))
    return found


def _unmet(plant: Plant, condition: Expr | None) -> Iterator[frozenset[_Fact]]:
    """Yield facts for each conjunct that is not true initially, whatever an event brings."""
    for part in () if condition is None else operands(condition, "and"):
        if _reads_event(part) or _value(plant, part) is True:
            continue
        read = support(plant, part)
        indexes = _indexes(plant, read[0]) if len(read) == 1 else ()
        some = frozenset((read[0], i) for i in indexes if _value(plant, part, {read[0]: i}) is True)
        yield some or _facts(plant, read)


def _facts(plant: Plant, variables: Sequence[int]) -> frozenset[_Fact]:
    """Return all facts about some variables."""
    return frozenset(
        (variable, index) for variable in variables for index in (_indexes(plant, variable) or [-1])
    )


def _indexes(plant: Plant, variable: int) -> Sequence[int]:
    """Return the indexes of the values of a location or a phase; none for data."""
    of = plant.variables[variable]
    return range(of.size) if of.kind in (VariableKind.LOCATION, VariableKind.PHASE) else ()


def _reads_event(expr: Expr) -> bool:
    return any(isinstance(node, ValueRef) for node in walk(expr))


def _value(plant: Plant, expr: Expr, changed: Mapping[int, int] = {}) -> Value | None:
    """Return the value of an expression initially, or with other values of some variables."""

    def look(leaf: Leaf) -> Value | None:
        variable = plant.variable_of(leaf)
        assert variable is not None, "it reads no event"
        return plant.variables[variable].read(leaf, changed.get(variable, plant.initial[variable]))

    try:
        return evaluate(expr, look)
    except Undefined:
        return None
