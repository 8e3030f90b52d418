"""Weakest preconditions (Dijkstra) of the state requirements before an event.

Where no uncontrollable event has to be considered, or only the next one, this is what synthesis
adds to a command's requirements, in terms of the model: ``User0.used + 1 + User1.used <= 20``.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from dataclasses import replace
from functools import partial
from itertools import product
from math import prod

from robosc.expr.traversal import rewritten
from robosc.expr.tree import FALSE, TRUE, Binary, Expr, Leaf, Literal, Unary
from robosc.plant.automaton import Edge, Event, LocalAutomaton, Plant
from robosc.plant.logic import conjunction, disjunction, junction, negation, simplified
from robosc.plant.support import support
from robosc.synthesis.controlled_system import stays_in_range, taken_where

_MOST_CHOICES = 8
_MOST_READ = 8
"""State variables that a condition may read for what keeps it to be looked for."""
_MOST_REQUIREMENTS = 2**7
"""State requirements that are followed through events, each for some milliseconds."""
_MOST_LASTING = 32
"""Conditions of one state requirement. A lift whose door opens by itself has nine."""


def precondition(plant: Plant, event: Event) -> Expr:
    """Return when all state requirements that a command affects hold after it; TRUE if unknown.

    Ranges are ignored: the plant does not do a command whose update would leave one.
    """
    conditions = _concerned(plant, event.writes)
    return conjunction(_before_command(plant, event, [conjunction(conditions)]))


def next_precondition(plant: Plant, event: Event) -> list[Expr]:
    """Return the same for the command and one uncontrollable event after it, as a conjunction.

    The uncontrollable event must not leave a range either. The simplest conditions come last.
    """
    conditions = [
        condition
        for following in plant.events
        if not following.controllable and not event.writes.isdisjoint(following.writes)
        for condition in _before_uncontrollable(
            plant, following, _concerned(plant, following.writes)
        )
    ]
    conditions += _concerned(plant, event.writes)
    return _before_command(plant, event, list(dict.fromkeys(conditions)))


def lasting_precondition(plant: Plant, event: Event) -> list[Expr]:
    """Return the same for the command and any number of uncontrollable events after it.

    Conditions on many variables, and all after the first few of one requirement, are left out; so
    are all where there are very many requirements.
    """
    if len(plant.invariants) > _MOST_REQUIREMENTS:
        return []
    conditions = [
        condition
        for invariant, _ in plant.invariants
        for condition in plant.lasting_conditions.of(invariant, partial(_lasting, plant))
        if not event.writes.isdisjoint(support(plant, condition))
    ]
    return _before_command(plant, event, conditions[::-1])


def _lasting(plant: Plant, invariant: Expr) -> list[Expr]:
    """Return what must hold for a state requirement to hold after any uncontrollable events."""
    found = [invariant]
    clauses = [_clause(invariant, True)]
    for condition in found:  # appended to below
        read = frozenset(support(plant, condition))
        if len(read) > _MOST_READ:
            break
        for event in plant.events:
            if event.controllable or event.writes.isdisjoint(read):
                continue
            moving = tuple(a for a in event.automata if not read.isdisjoint(a.writes))
            event = replace(event, automata=moving)
            for before in _before_uncontrollable(plant, event, [condition]):
                clause = _clause(before := simplified(before), True)
                if before == TRUE or any(clause >= known for known in clauses):
                    continue
                if len(found) == _MOST_LASTING:
                    return found
                found.append(before)
                clauses.append(clause)
    return found


def _clause(condition: Expr, polarity: bool) -> frozenset[tuple[Expr, bool]]:
    """Return the operands of a disjunction, each with whether it is not negated."""
    if isinstance(condition, Unary) and condition.operator == "!":
        return _clause(condition.operand, not polarity)
    joined = junction(condition, polarity)
    if joined is None or joined.conjunctive:
        return frozenset([(condition, polarity)])
    return frozenset[tuple[Expr, bool]]().union(*(_clause(*part) for part in joined.parts))


def _concerned(plant: Plant, written: frozenset[int]) -> list[Expr]:
    """Return the state requirements that read one of the state variables."""
    return [
        condition
        for condition, _ in plant.invariants
        if not written.isdisjoint(support(plant, condition))
    ]


def _before_command(plant: Plant, event: Event, conditions: Sequence[Expr]) -> list[Expr]:
    """Return the conditions before a command; none if it has values or components may ignore it."""
    if event.parameters or not all(a.blocking for a in event.automata):
        return []
    return [
        disjunction([*_others(plant, event, edges, located=False), kept])
        for edges in _choices(event)
        for condition in conditions
        if (kept := simplified(_after(plant, event, edges, condition))) != TRUE
    ]


def _before_uncontrollable(
    plant: Plant, event: Event, conditions: Sequence[Expr]
) -> Iterator[Expr]:
    """Yield the conditions before an event that keep some conditions and ranges after it."""
    if event.parameters:
        return
    for edges in _choices(event):
        others = list(_others(plant, event, edges, located=True))
        kept = [_after(plant, event, edges, condition) for condition in conditions]
        inside = [condition for edge in edges for condition in stays_in_range(plant, edge)]
        computed = [one for one in inside if isinstance(one.left, Unary | Binary)]
        for condition in (*kept, *computed):
            yield disjunction([*others, condition])


def _choices(event: Event) -> Iterable[tuple[Edge, ...]]:
    """Return the combinations of one edge per automaton; none if these are too many."""
    if prod(len(automaton.edges) for automaton in event.automata) > _MOST_CHOICES:
        return ()
    return product(*(automaton.edges for automaton in event.automata))


def _others(plant: Plant, event: Event, edges: tuple[Edge, ...], located: bool) -> Iterator[Expr]:
    """Yield when an automaton does not take its edge (``located``: or is not in its source)."""
    for automaton, edge in zip(event.automata, edges, strict=True):
        yield from map(negation, _taken(plant, automaton, edge, located))


def _taken(plant: Plant, automaton: LocalAutomaton, edge: Edge, located: bool) -> list[Expr]:
    """Return what must hold for an edge to be taken; assuming that one is, unless ``located``."""
    here, *first = taken_where(plant, automaton, edge)
    alike = [other for other in automaton.edges if other.source == edge.source]
    found = [here] if located or len(alike) < len(automaton.edges) else []
    return [*found, *first] if located or len(alike) > 1 else found


def _after(plant: Plant, event: Event, edges: tuple[Edge, ...], condition: Expr) -> Expr:
    return after(plant, event, list(zip(event.automata, edges, strict=True)), condition)


def after(
    plant: Plant, event: Event, taken: Sequence[tuple[LocalAutomaton, Edge]], condition: Expr
) -> Expr:
    """Return a condition on the state after an event as one on the state before it.

    ``taken`` are the edges that it takes; automata that are not named stay as they are.
    """
    values = {variable: expr for _, edge in taken for variable, expr in edge.updates}
    places = {automaton.variable: edge.target for automaton, edge in taken}
    if event.phase is not None:
        places[event.phase.variable] = event.phase.target

    def leaf(node: Literal | Leaf) -> Expr:
        index = plant.variable_of(node)
        if index is None:
            return node
        if index in places:
            return TRUE if plant.variables[index].read(node, places[index]) else FALSE
        return values.get(index, node)

    return rewritten(condition, leaf)
