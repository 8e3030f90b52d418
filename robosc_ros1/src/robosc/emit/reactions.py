"""What an event does to the controller, and when the plant can do it.

Conditions and right-hand sides are texts over the state before the event; the template evaluates
all of them before it assigns anything, because assignments are simultaneous.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from dataclasses import dataclass

from robosc.emit.naming import place
from robosc.emit.python import (
    Attributes,
    in_controller,
    literal,
    operand,
    reads_array,
    within,
)
from robosc.emit.views import BranchView, ReactionView
from robosc.ir.automaton import Edge, Event, LocalAutomaton, Plant, StateVariable
from robosc.ir.expr import may_be_huge
from robosc.model.entities import Variable
from robosc.model.expr import Expr
from robosc.model.types import DoubleType, IntegerType

__all__ = ["Reactions", "Spelling", "alike"]


@dataclass(frozen=True)
class Spelling:
    """Expressions as texts with the names that were given out."""

    attributes: Attributes

    def text(self, expr: Expr) -> str:
        return in_controller(expr, self.attributes)

    def operand(self, expr: Expr) -> str:
        """The text of a condition as an operand of ``and``."""
        return operand(expr, self.text(expr))


class Reactions:
    """Describes the events of one plant."""

    def __init__(self, plant: Plant, spelling: Spelling) -> None:
        self.plant = plant
        self.spelling = spelling
        components = plant.robot.components
        self.variables: dict[str, Variable] = {
            v.key: v for c in components if c.behaviour for v in c.behaviour.variables
        }

    def reaction(self, event: Event) -> ReactionView:
        automata = []
        changed: dict[str, None] = {}
        for automaton in event.automata:
            branches = []
            for edges in alike(automaton.edges):
                branch = self._branch(event, automaton, edges)
                changed.update(dict.fromkeys(name for name, _ in branch.effects))
                branches.append(branch)
            if any(branch.effects for branch in branches):
                automata.append((automaton.component, tuple(branches)))
        phase = event.phase
        return ReactionView(
            busy=None if phase is None else self.spelling.attributes.phases[event.key],
            busy_before=phase is not None and phase.source == 1,
            busy_after=phase is not None and phase.target == 1,
            automata=tuple(automata),
            attributes=tuple(changed),
        )

    def _branch(self, event: Event, automaton: LocalAutomaton, edges: list[Edge]) -> BranchView:
        edge = edges[0]
        effects = []
        for index, expr in edge.updates:
            variable = self.variables[self.plant.variables[index].name]
            effects.append(self._effect(event, variable, expr))
        for assignment in edge.data:
            variable = self.variables[f"{automaton.component}.{assignment.variable}"]
            effects.append(self._effect(event, variable, assignment.value))
        location = self.plant.variables[automaton.variable]
        if any(e.source != e.target for e in edges):
            target = literal(location.values[edge.target])
            effects.append((self.spelling.attributes.locations[automaton.component], target))
        return BranchView(
            self._edge_condition(location, edges, automaton), place(edge.span), tuple(effects)
        )

    def _edge_condition(
        self, location: StateVariable, edges: list[Edge], automaton: LocalAutomaton
    ) -> str:
        guard = edges[0].guard
        parts = [self.location_test(location, [e.source for e in edges])]
        if guard is not None:
            text = self.spelling.text(guard)
            if reads_array(guard):
                text = f"self.holds(lambda: {text}, {literal(place(edges[0].span))})"
                parts.append(text)
            else:
                parts.append(operand(guard, text))
        return " and ".join(part for part in parts if part)

    def location_test(self, location: StateVariable, sources: Iterable[int]) -> str:
        """Whether the component is in one of the states; empty if it always is."""
        states = [str(location.values[source]) for source in sources]
        attribute = f"self.{self.spelling.attributes.locations[location.name]}"
        if len(states) == location.size:
            return ""
        if len(states) == 1:
            return f"{attribute} == {literal(states[0])}"
        return f"{attribute} in ({', '.join(literal(s) for s in states)})"

    def _effect(self, event: Event, variable: Variable, expr: Expr) -> tuple[str, str]:
        attribute = self.spelling.attributes.variables[variable.key]
        text = self.spelling.text(expr)
        if isinstance(variable.type, DoubleType) and isinstance(expr.type, IntegerType):
            text = f"{'widen' if may_be_huge(expr) else 'float'}({text})"
        where = literal(place(expr.span)) if expr.span is not None else '""'
        if not within(expr, variable.type):
            assert isinstance(variable.type, IntegerType)
            assert variable.type.bounds is not None
            low, high = variable.type.bounds
            if not variable.in_state:
                text = f"self.kept({text}, {low}, {high}, self.{attribute}, {where})"
            elif not event.controllable:
                text = f"in_range({text}, {low}, {high}, {literal(variable.key)})"
        if reads_array(expr):
            text = f"self.assigned(lambda: {text}, self.{attribute}, {where})"
        return attribute, text

    def synchronisation(self, event: Event) -> Iterator[str]:
        """Conditions under which the plant can do a controllable event, its phase apart."""
        for automaton in event.automata:
            location = self.plant.variables[automaton.variable]
            ways = []
            free = True
            for edges in alike(automaton.edges):
                ranges = list(self._ranges(edges[0]))
                where = self._edge_condition(location, edges, automaton)
                free = free and not ranges
                if automaton.blocking:
                    ways.append(" and ".join(part for part in (where, *ranges) if part))
                elif ranges:
                    inside = " and ".join(ranges)
                    yield f"(not ({where}) or {inside})" if where else inside
            if not automaton.blocking or (free and self._always(automaton, location)):
                continue
            yield ways[0] if len(ways) == 1 else f"({' or '.join(ways)})" if ways else "False"

    def _always(self, automaton: LocalAutomaton, location: StateVariable) -> bool:
        open_edges = {e.source for e in automaton.edges if e.guard is None}
        return len(open_edges) == location.size

    def _ranges(self, edge: Edge) -> Iterator[str]:
        for index, expr in edge.updates:
            variable = self.variables[self.plant.variables[index].name]
            if not within(expr, variable.type):
                assert isinstance(variable.type, IntegerType)
                assert variable.type.bounds is not None
                low, high = variable.type.bounds
                yield f"{low} <= {self.spelling.text(expr)} <= {high}"


def alike(edges: Iterable[Edge]) -> list[list[Edge]]:
    """The edges of one transition in one group: on the automaton level there is one per state."""
    groups: dict[tuple[int, int, int], list[Edge]] = {}
    for edge in edges:
        span = edge.span
        groups.setdefault((id(span.source), span.start, span.end), []).append(edge)
    return list(groups.values())
