"""What an event does to the controller, and when the plant can do it, as Python text.

Assignments are simultaneous: conditions and right-hand sides see the state before the event, and
nothing is changed if one of them raises Mismatch. So an attribute is assigned at once only if
nothing that is evaluated afterwards reads it or raises; else its new value waits in a local
variable of its name.
"""

from __future__ import annotations

import re
from collections.abc import Iterable, Iterator
from dataclasses import dataclass, replace

from robosc.emit.line_breaks import unparenthesised
from robosc.emit.literals import without_texts
from robosc.emit.naming import PythonNames, place
from robosc.emit.python import Attributes, literal, operand, within
from robosc.emit.views import PartnerView, ReactionView
from robosc.ir.automaton import Edge, Event, LocalAutomaton, Plant, StateVariable
from robosc.ir.formulas import exact, may_be_huge
from robosc.language.events import EventKind
from robosc.model.entities import Variable
from robosc.model.expr import Expr
from robosc.model.traversal import may_be_undefined
from robosc.model.types import DoubleType, IntegerType

__all__ = ["Reactions", "alike", "attributes_read"]

_ATTRIBUTE = re.compile(r"\bself\.(\w+)\b(?!\()")


@dataclass(frozen=True)
class _Branch:
    """One way in which a component takes part: ``condition`` (empty: always) and its effects.

    ``effects`` are (attribute, right-hand side), both over the old state.
    """

    condition: str
    place: str
    effects: tuple[tuple[str, str], ...]


@dataclass(frozen=True)
class _LocalReaction:
    """What an event does to one component."""

    component: str
    branches: tuple[_Branch, ...]

    @property
    def texts(self) -> list[str]:
        """All that is evaluated."""
        effects = [text for branch in self.branches for _, text in branch.effects]
        return [branch.condition for branch in self.branches] + effects


def attributes_read(texts: Iterable[str]) -> frozenset[str]:
    """The controller's attributes that expressions read, calls apart."""
    return frozenset(n for text in texts for n in _ATTRIBUTE.findall(without_texts(text)))


class Reactions:
    """Describes the events of one plant."""

    def __init__(self, plant: Plant, attributes: Attributes) -> None:
        self.plant = plant
        self.attributes = attributes
        self.variables = plant.robot.variables

    def reaction(self, event: Event, tested: bool = False) -> ReactionView:
        """What an event does; ``tested``: its one edge is known to be enabled."""
        parts = []
        for automaton in event.automata:
            groups = alike(automaton.edges)
            branches = tuple(self._branch(event, automaton, edges) for edges in groups)
            if tested:
                branches = tuple(replace(branch, condition="") for branch in branches)
            if any(branch.effects for branch in branches):
                parts.append(_LocalReaction(automaton.component, branches))
        body = list(_body(parts))
        changed = {name: None for part in parts for b in part.branches for name, _ in b.effects}
        phase = event.phase
        if phase is not None:
            busy = self.attributes.phases[event.key]
            if phase.sources == (1,):
                wrong = "silent" if event.kind is EventKind.TIMEOUT else "not under way"
                mismatch = f'    raise Mismatch("{event.name} is {wrong}")'
                body = [f"if not self.{busy}:", mismatch, *body]
            if phase.sources != (phase.target,):
                body.append(f"self.{busy} = {phase.target == 1}")
                changed[busy] = None
        return ReactionView(tuple(body), tuple(changed))

    def _branch(self, event: Event, automaton: LocalAutomaton, edges: list[Edge]) -> _Branch:
        edge = edges[0]
        effects = []
        for assignment in edge.assignments:
            variable = self.variables[f"{automaton.component}.{assignment.variable}"]
            effects.append(self._effect(event, variable, assignment.value))
        location = self.plant.variables[automaton.variable]
        if any(e.source != e.target for e in edges):
            target = literal(location.values[edge.target])
            effects.append((self.attributes.locations[automaton.component], target))
        entries = self.attributes.entries.get(automaton.component)
        if edge.enters and entries is not None:
            effects.append((entries, f"self.{entries} + 1"))
        return _Branch(
            self._edge_condition(location, edges, automaton), place(edge.span), tuple(effects)
        )

    def _edge_condition(
        self, location: StateVariable, edges: list[Edge], automaton: LocalAutomaton
    ) -> str:
        guard = edges[0].guard
        parts = [self.location_test(location, [e.source for e in edges])]
        if guard is not None:
            text = self.attributes.text(guard)
            if may_be_undefined(exact(guard)):
                text = f"self.holds(lambda: {text}, {literal(place(edges[0].span))})"
                parts.append(text)
            else:
                parts.append(operand(guard, text))
        return " and ".join(part for part in parts if part)

    def condition(self, automaton: LocalAutomaton) -> str:
        """Where an automaton with one edge takes part; empty: always."""
        location = self.plant.variables[automaton.variable]
        return self._edge_condition(location, list(automaton.edges), automaton)

    def location_test(self, location: StateVariable, sources: Iterable[int]) -> str:
        """Whether the component is in one of the states; empty if it always is."""
        states = [str(location.values[source]) for source in sources]
        attribute = f"self.{self.attributes.locations[location.name]}"
        if len(states) == location.size:
            return ""
        if len(states) == 1:
            return f"{attribute} == {literal(states[0])}"
        return f"{attribute} in ({', '.join(literal(s) for s in states)})"

    def _effect(self, event: Event, variable: Variable, expr: Expr) -> tuple[str, str]:
        attribute = self.attributes.variables[variable.key]
        text = self.attributes.text(expr)
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
        if may_be_undefined(exact(expr)):
            text = f"self.assigned(lambda: {text}, self.{attribute}, {where})"
        return attribute, text

    def synchronisation(self, event: Event) -> str:
        """The condition under which the plant can do a controllable event, its phase apart; empty
        if it always can."""
        conditions = [condition for _, condition in self._synchronisation(event)]
        if len(conditions) == 1:
            return unparenthesised(conditions[0])
        return " and ".join(conditions)

    def partners(self, event: Event, name: str, names: PythonNames) -> tuple[PartnerView, ...]:
        """The components of that condition, each with whether it can take part, the ranges of its
        variables apart; several have a method each, one alone has that of the whole."""
        parts = list(self._synchronisation(event, ranges=False))
        if len(parts) == 1 and parts == list(self._synchronisation(event)):
            return (PartnerView(parts[0][0], parts[0][1], ""),)
        return tuple(
            PartnerView(component, unparenthesised(text), names.take(f"partner_{number}_in_{name}"))
            for number, (component, text) in enumerate(parts, 1)
        )

    def _synchronisation(self, event: Event, ranges: bool = True) -> Iterator[tuple[str, str]]:
        for automaton in event.automata:
            location = self.plant.variables[automaton.variable]
            ways = []
            free = True
            for edges in alike(automaton.edges):
                inside = " and ".join(self._ranges(edges[0])) if ranges else ""
                where = self._edge_condition(location, edges, automaton)
                free = free and not inside
                if automaton.blocking:
                    ways.append(" and ".join(part for part in (where, inside) if part))
                elif inside:
                    text = f"(not ({where}) or {inside})" if where else inside
                    yield automaton.component, text
            if not automaton.blocking or (free and self._always(automaton, location)):
                continue
            text = ways[0] if len(ways) == 1 else f"({' or '.join(ways)})" if ways else "False"
            yield automaton.component, text

    def _always(self, automaton: LocalAutomaton, location: StateVariable) -> bool:
        open_edges = {e.source for e in automaton.edges if e.guard is None}
        return len(open_edges) == location.size

    def _ranges(self, edge: Edge) -> Iterator[str]:
        for index, expr in edge.updates:
            variable = self.variables.get(self.plant.variables[index].name)
            if variable is not None and not within(expr, variable.type):
                assert isinstance(variable.type, IntegerType)
                assert variable.type.bounds is not None
                low, high = variable.type.bounds
                yield f"{low} <= {self.attributes.text(expr)} <= {high}"


def alike(edges: Iterable[Edge]) -> list[list[Edge]]:
    """The edges of one transition in one group: on the automaton level there is one per state.

    In each state the first edge counts, so that a group comes after all that stand before one of
    its edges.
    """
    groups: dict[tuple[object, ...], list[Edge]] = {}
    ranks: dict[tuple[object, ...], int] = {}
    seen: dict[int, int] = {}
    for edge in edges:
        span = edge.span
        key = id(span.source), span.start, span.end, edge.guard, edge.updates, edge.assignments
        groups.setdefault(key, []).append(edge)
        seen[edge.source] = rank = seen.get(edge.source, 0) + 1
        ranks[key] = max(ranks.get(key, 0), rank)
    return [groups[key] for key in sorted(groups, key=ranks.__getitem__)]


def _body(parts: list[_LocalReaction]) -> Iterator[str]:
    """The statements that change the state."""
    waiting = _waiting(parts)
    assigned = {name for part in parts for name in _always_assigned(part)}
    for name in waiting:
        if name not in assigned:
            yield f"{name} = self.{name}"
    for part in parts:
        first = part.branches[0]
        if not first.condition:
            yield f"# {part.component} ({first.place})"
            yield from _effects(first, waiting, "")
            continue
        yield f"# {part.component}"
        for number, branch in enumerate(part.branches):
            word = "if" if number == 0 else "elif"
            head = f"{word} {branch.condition}:" if branch.condition else "else:"
            yield f"{head}  # {branch.place}"
            yield from _effects(branch, waiting, "    ") if branch.effects else ["    pass"]
    for name in waiting:
        yield f"self.{name} = {name}"


def _effects(branch: _Branch, waiting: Iterable[str], indent: str) -> Iterator[str]:
    for name, text in branch.effects:
        change = re.fullmatch(rf"self\.{name} ([-+]) ([\w.]+)", text)
        if name in waiting:
            yield f"{indent}{name} = {text}"
        elif change:
            yield f"{indent}self.{name} {change[1]}= {change[2]}"
        else:
            yield f"{indent}self.{name} = {text}"


def _always_assigned(part: _LocalReaction) -> Iterator[str]:
    if not part.branches[0].condition:
        yield from (name for name, _ in part.branches[0].effects)


def _waiting(parts: list[_LocalReaction]) -> list[str]:
    """The attributes whose new values must wait until all of the event is evaluated."""
    found: dict[str, None] = {}
    for number, part in enumerate(parts):
        later = [text for other in parts[number + 1 :] for text in other.texts]
        for branch in part.branches:
            for at, (name, _) in enumerate(branch.effects):
                after = [text for _, text in branch.effects[at + 1 :]] + later
                if name in attributes_read(after) or any(
                    "in_range(" in without_texts(text) for text in after
                ):
                    found[name] = None
    return list(found)
