"""Which events may end in another state if they come in the other order.

Whoever listens to a robot gets messages of different topics in another order than the controller
did. That matters only for events of which one reads or writes what the other one writes; and, where
a command decides on a state that depends on such an order, for all that it is decided on.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, field
from itertools import combinations

from robosc.expr import traversal, tree
from robosc.language.events import EventKind, Kind
from robosc.plant.automaton import Event, LocalAutomaton, Plant, VariableKind
from robosc.plant.logic import exact
from robosc.supervisor import Supervisor

Place = tuple[VariableKind, str]
"""A part of the state: a component's location, a phase, or a variable of the model."""


@dataclass
class _Effects:
    """What some events read and write."""

    reads: set[Place] = field(default_factory=set)
    writes: set[Place] = field(default_factory=set)

    def add(self, other: _Effects) -> None:
        self.reads |= other.reads
        self.writes |= other.writes

    def clashes(self, other: _Effects) -> bool:
        """Whether the order of one of these events and one of others may matter."""
        theirs = other.reads | other.writes
        return not (self.writes.isdisjoint(theirs) and other.writes.isdisjoint(self.reads))


def not_commuting(supervisor: Supervisor) -> tuple[tuple[str, ...], ...]:
    """Return groups of communications, by key, and of components with delayed transitions: events
    of different groups commute, and so do those that are in none."""
    plant = supervisor.plant
    taus = [_effects(plant, event) for event in plant.events if event.kind is EventKind.TAU]
    found: dict[str, _Effects] = {}
    for event in plant.events:
        if event.kind is not EventKind.TAU:
            found.setdefault(event.key, _Effects()).add(_effects(plant, event))
    for effects in found.values():
        _complete(effects, taus)
    groups = _Groups()
    for (one, its), (other, theirs) in combinations(found.items(), 2):
        if its.clashes(theirs):
            groups.join(one, other)
    depends = {place for key in found if key in groups for place in found[key].writes}
    for guard in supervisor.guards:
        key = guard.event.key
        decides = {*_places(guard.expr), *_places(guard.required)}
        if guard.event.kind is EventKind.REQUEST and not depends.isdisjoint(decides):
            deciding = {k for k, effects in found.items() if not effects.writes.isdisjoint(decides)}
            groups.join(key, *deciding)
    topics: dict[str, list[str]] = {}
    for key, communication in plant.robot.communications.items():
        if communication.kind is Kind.OUTGOING:
            topics.setdefault(communication.ros_name, []).append(key)
    for keys in topics.values():
        if any(key in groups for key in keys):  # a message is one event for all of its topic
            groups.join(*keys)
    return groups.found


class _Groups:
    """Disjoint sets of keys."""

    def __init__(self) -> None:
        self._of: dict[str, set[str]] = {}

    def __contains__(self, key: str) -> bool:
        return key in self._of

    def join(self, *keys: str) -> None:
        """Put the groups of these keys together."""
        together = set(keys).union(*(self._of.get(key, ()) for key in keys))
        self._of.update(dict.fromkeys(together, together))

    @property
    def found(self) -> tuple[tuple[str, ...], ...]:
        return tuple(sorted({tuple(sorted(group)) for group in self._of.values()}))


def _complete(effects: _Effects, taus: list[_Effects]) -> None:
    """Add what internal transitions do after events."""
    size = -1
    while size != len(effects.reads) + len(effects.writes):
        size = len(effects.reads) + len(effects.writes)
        for tau in taus:
            if not effects.writes.isdisjoint(tau.reads):
                effects.add(tau)


def _effects(plant: Plant, event: Event) -> _Effects:
    effects = _Effects()
    if event.phase is not None:
        phase = (VariableKind.PHASE, event.key)
        effects.reads.add(phase)
        effects.writes.add(phase)
    for automaton in event.automata:
        _add_automaton(effects, plant, automaton)
    for restriction in plant.restrictions.get((event.kind, event.key), ()):
        effects.reads.update(_places(restriction.condition))
    return effects


def _add_automaton(effects: _Effects, plant: Plant, automaton: LocalAutomaton) -> None:
    variable = plant.variables[automaton.variable]
    location = (variable.kind, variable.name)
    every = {edge.source for edge in automaton.edges if edge.guard is None}
    if len(every) < variable.size or len({edge.assignments for edge in automaton.edges}) > 1:
        effects.reads.add(location)
    for edge in automaton.edges:
        if edge.guard is not None:
            effects.reads.update(_places(edge.guard))
        if edge.target != edge.source or edge.enters:
            effects.writes.add(location)
        for assignment in edge.assignments:
            effects.reads.update(_places(assignment.value))
            effects.writes.add((VariableKind.DATA, f"{automaton.component}.{assignment.variable}"))


def _places(expr: tree.Expr) -> Iterator[Place]:
    for part in traversal.walk(exact(expr)):
        match part:
            case tree.VariableRef():
                yield VariableKind.DATA, part.key
            case tree.StateRef():
                yield VariableKind.LOCATION, part.component
            case tree.PhaseRef():
                yield VariableKind.PHASE, part.communication
