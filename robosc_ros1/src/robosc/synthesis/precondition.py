"""What state requirements demand of the state before an event (Dijkstra's weakest precondition).

Where no uncontrollable event has to be considered, or only the next one, this is what synthesis
adds to a command's requirements, and in the words of the model: ``User0.used + 1 + User1.used <=
20``.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from itertools import product
from math import prod

from robosc.ir.automaton import Edge, Event, LocalAutomaton, Plant
from robosc.ir.formulas import conjunction, disjunction, junction, negation
from robosc.model.expr import FALSE, TRUE, Binary, Expr, Leaf, Literal, PhaseRef, StateRef, Unary
from robosc.model.traversal import rewritten
from robosc.model.types import BooleanType
from robosc.synthesis.vectorised import support, variable_of

__all__ = ["next_precondition", "precondition"]

_MOST_CHOICES = 8


def precondition(plant: Plant, event: Event) -> Expr:
    """When all state requirements that a command concerns hold after it; TRUE if that is unclear.

    Its ranges are left aside: where an update would leave one the plant does not do the command.
    """
    conditions = _concerned(plant, _writes(plant, event))
    return conjunction(_before_command(plant, event, [conjunction(conditions)]))


def next_precondition(plant: Plant, event: Event) -> list[Expr]:
    """When they hold after a command and after an uncontrollable event that comes next, and that
    one leaves no range: conditions of which all must hold, the plainest last."""
    written = _writes(plant, event)
    conditions = [
        condition
        for number, following in enumerate(plant.events)
        if not following.controllable and not written.isdisjoint(plant.writes[number])
        for condition in _before_uncontrollable(plant, following)
    ]
    conditions += _concerned(plant, written)
    return _before_command(plant, event, list(dict.fromkeys(conditions)))


def _writes(plant: Plant, event: Event) -> frozenset[int]:
    return plant.writes[plant.number(event)]


def _concerned(plant: Plant, written: frozenset[int]) -> list[Expr]:
    """The state requirements that read some of the state variables."""
    return [
        condition
        for condition, _ in plant.invariants
        if not written.isdisjoint(support(plant, condition))
    ]


def _before_command(plant: Plant, event: Event, conditions: Sequence[Expr]) -> list[Expr]:
    """What must hold so that the conditions do after a command; nothing if that is unclear."""
    if event.parameters or not all(a.blocking for a in event.automata):
        return []
    return [
        disjunction([*_others(plant, event, edges, located=False), after])
        for edges in _choices(event)
        for condition in conditions
        if (after := _simplified(_after(plant, event, edges, condition))) != TRUE
    ]


def _before_uncontrollable(plant: Plant, event: Event) -> Iterator[Expr]:
    """What must hold so that state requirements and ranges do after it if it is possible."""
    conditions = _concerned(plant, _writes(plant, event))
    if event.parameters:
        return
    for edges in _choices(event):
        others = list(_others(plant, event, edges, located=True))
        after = [_after(plant, event, edges, condition) for condition in conditions]
        for condition in (*after, *_ranges(plant, edges)):
            yield disjunction([*others, condition])


def _choices(event: Event) -> Iterable[tuple[Edge, ...]]:
    """An edge of each automaton, unless these are too many."""
    if prod(len(automaton.edges) for automaton in event.automata) > _MOST_CHOICES:
        return ()
    return product(*(automaton.edges for automaton in event.automata))


def _ranges(plant: Plant, edges: tuple[Edge, ...]) -> Iterator[Expr]:
    """That updates leave no range."""
    for edge in edges:
        for variable, expr in edge.updates:
            values = plant.variables[variable].values
            if isinstance(values, range) and isinstance(expr, Unary | Binary):
                for operator, value in (("<=", values[-1]), (">=", values[0])):
                    yield Binary(operator, expr, Literal(value, expr.type), BooleanType())


def _others(plant: Plant, event: Event, edges: tuple[Edge, ...], located: bool) -> Iterator[Expr]:
    """When automata that take part do not take these edges; ``located``: or take no part."""
    for automaton, edge in zip(event.automata, edges, strict=True):
        yield from map(negation, _taken(plant, automaton, edge, located))


def _taken(plant: Plant, automaton: LocalAutomaton, edge: Edge, located: bool) -> Iterator[Expr]:
    """When an automaton takes this edge; if it takes part, unless ``located``."""
    if located or any(other.source != edge.source for other in automaton.edges):
        yield StateRef(automaton.component, _location(plant, automaton.variable, edge.source))
    alike = [other for other in automaton.edges if other.source == edge.source]
    for before in alike[: alike.index(edge)]:
        yield FALSE if before.guard is None else negation(before.guard)
    if edge.guard is not None and (located or len(alike) > 1):
        yield edge.guard


def _after(plant: Plant, event: Event, edges: tuple[Edge, ...], condition: Expr) -> Expr:
    """A condition on the state after an event, over the state before it."""
    values = {variable: expr for edge in edges for variable, expr in edge.updates}
    places = {a.variable: edge.target for a, edge in zip(event.automata, edges, strict=True)}
    if event.phase is not None:
        places[event.phase.variable] = event.phase.target

    def leaf(node: Literal | Leaf) -> Expr:
        index = None if isinstance(node, Literal) else variable_of(plant, node)
        if index in places:
            if isinstance(node, StateRef):
                return TRUE if _location(plant, index, places[index]) == node.state else FALSE
            if isinstance(node, PhaseRef):
                return TRUE if places[index] else FALSE
        return values.get(index, node) if index is not None else node

    return rewritten(condition, leaf)


def _location(plant: Plant, variable: int, place: int) -> str:
    return str(plant.variables[variable].values[place])


def _simplified(expr: Expr) -> Expr:
    """Without constant parts of ``and``, ``or``, ``=>`` and ``!``."""
    if isinstance(expr, Unary) and expr.operator == "!":
        return negation(_simplified(expr.operand))
    found = junction(expr, True)
    if found is None or not isinstance(expr, Binary):
        return expr
    conjunctive, parts = found
    sides = [
        _simplified(part) if polarity else negation(_simplified(part)) for part, polarity in parts
    ]
    return conjunction(sides) if conjunctive else disjunction(sides)
