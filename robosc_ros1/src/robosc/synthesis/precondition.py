"""What state requirements demand of the state before an event (Dijkstra's weakest precondition).

Where no uncontrollable event has to be considered, this is what synthesis adds to a command's
requirements, and in the words of the model: ``User0.used + 1 + User1.used <= 20``.
"""

from __future__ import annotations

from collections.abc import Iterator
from itertools import product
from math import prod

from robosc.ir.automaton import Edge, Event, LocalAutomaton, Plant
from robosc.ir.formulas import conjunction, disjunction, junction, negation
from robosc.model.expr import FALSE, TRUE, Binary, Expr, Leaf, Literal, PhaseRef, StateRef, Unary
from robosc.model.traversal import rewritten
from robosc.synthesis.vectorised import support, variable_of

__all__ = ["precondition"]

_MOST_CHOICES = 8


def precondition(plant: Plant, event: Event) -> Expr | None:
    """When all state requirements that a command concerns hold after it; None if that is unclear.

    Its ranges are left aside: where an update would leave one the plant does not do the command.
    """
    written = plant.writes[next(n for n, e in enumerate(plant.events) if e is event)]
    concerned = [
        condition
        for condition, _ in plant.invariants
        if not written.isdisjoint(support(plant, condition))
    ]
    automata = [a for a in event.automata if a.blocking]
    if (
        not concerned
        or event.parameters
        or len(automata) < len(event.automata)
        or prod(len(a.edges) for a in automata) > _MOST_CHOICES
    ):
        return None
    parts: list[Expr] = []
    for edges in product(*(automaton.edges for automaton in automata)):
        taken = [
            condition
            for automaton, edge in zip(automata, edges, strict=True)
            for condition in _taken(plant, automaton, edge)
        ]
        after = _simplified(_after(plant, event, automata, edges, conjunction(concerned)))
        parts.append(disjunction([*(negation(condition) for condition in taken), after]))
    return conjunction(parts)


def _taken(plant: Plant, automaton: LocalAutomaton, edge: Edge) -> Iterator[Expr]:
    """When an automaton that takes part takes this edge."""
    if any(other.source != edge.source for other in automaton.edges):
        yield StateRef(automaton.component, _location(plant, automaton.variable, edge.source))
    alike = [other for other in automaton.edges if other.source == edge.source]
    for before in alike[: alike.index(edge)]:
        yield FALSE if before.guard is None else negation(before.guard)
    if edge.guard is not None and len(alike) > 1:
        yield edge.guard


def _after(
    plant: Plant,
    event: Event,
    automata: list[LocalAutomaton],
    edges: tuple[Edge, ...],
    condition: Expr,
) -> Expr:
    """A condition on the state after an event, over the state before it."""
    values = {variable: expr for edge in edges for variable, expr in edge.updates}
    places = {a.variable: edge.target for a, edge in zip(automata, edges, strict=True)}
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
