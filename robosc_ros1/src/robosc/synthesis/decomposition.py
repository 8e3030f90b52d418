"""Decomposition of a plant into independent parts that share no event, variable or requirement.

Parts are solved separately: the supervisor of the plant consists of those of its parts, its states
are the product of theirs, and an event of one part leaves the others unchanged. Components also
belong to one part if a warning could be about both of them (commands to one topic, the conditions
of provided data), or if the controller handles their events together: a message that both receive,
a command of one that is preferred to a command of the other.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from math import prod
from typing import Any, TypeAlias

from robosc.ir.automaton import Event, Plant, VariableKind
from robosc.model.entities import EventKind, Kind
from robosc.model.expr import FALSE, Expr
from robosc.supervisor import Explanation, Step, Supervisor
from robosc.synthesis.system import inputs
from robosc.synthesis.vectorised import event_support, support

__all__ = ["combined", "independent_parts"]

_SMALL = 2**12
"""Product size up to which a part may be joined with others."""

_Identity: TypeAlias = tuple[EventKind, str, int]
"""What identifies an event of a plant: its kind, key and index."""


@dataclass(frozen=True, slots=True)
class _Group:
    """Variables, events and invariants of a plant that belong together, by number."""

    variables: list[int] = field(default_factory=list)
    events: list[int] = field(default_factory=list)
    invariants: list[int] = field(default_factory=list)

    def add(self, other: _Group) -> None:
        self.variables.extend(other.variables)
        self.events.extend(other.events)
        self.invariants.extend(other.invariants)


def independent_parts(plant: Plant, size: int) -> list[Plant]:
    """Return the independent parts of a plant, in model order; the plant itself if there is one.

    Small parts are joined up to a product of ``size`` combinations of values.
    """
    sets = _DisjointSets(plant)
    groups: dict[int, _Group] = {}
    for variable in range(len(plant.variables)):
        groups.setdefault(sets.find(variable), _Group()).variables.append(variable)
    # What reads and writes no variable may be in any part: it goes to the first.
    first = next(iter(groups.values()), _Group())
    for event in range(len(plant.events)):
        groups.get(sets.find(sets.node(event)), first).events.append(event)
    for number, (condition, _) in enumerate(plant.invariants):
        read = support(plant, condition)
        (groups[sets.find(read[0])] if read else first).invariants.append(number)
    bundles = _bundles(plant, groups.values(), size)
    return [plant] if len(bundles) < 2 else [_part(plant, bundle) for bundle in bundles]


def _bundles(plant: Plant, groups: Iterable[_Group], size: int) -> list[_Group]:
    """Return the groups, small neighbouring ones joined."""
    found: list[_Group] = []
    open_, total = _Group(), size + 1
    for group in groups:
        own = prod(plant.variables[variable].size for variable in group.variables)
        if own > _SMALL:
            found.append(group)
            continue
        total *= own
        if total > size:
            found.append(open_ := _Group())
            total = own
        open_.add(group)
    return [
        _Group(sorted(bundle.variables), sorted(bundle.events), sorted(bundle.invariants))
        for bundle in found
    ]


class _DisjointSets:
    """Union-find over the variables and events of a plant (Tarjan, J. ACM 22(2), 1975)."""

    def __init__(self, plant: Plant) -> None:
        self.plant = plant
        self.parent = list(range(len(plant.variables) + len(plant.events)))
        self.requests = {
            event.key: self.node(number)
            for number, event in enumerate(plant.events)
            if event.kind is EventKind.REQUEST
        }
        for number, event in enumerate(plant.events):
            self._join([self.node(number), *event_support(plant, event)])
        for condition, _ in plant.invariants:
            self._join(support(plant, condition))
        self._join_components()
        self._join_requirements()
        self._join_data()
        self._join_messages()

    def node(self, event: int) -> int:
        return len(self.plant.variables) + event

    def find(self, node: int) -> int:
        while self.parent[node] != node:
            self.parent[node] = self.parent[self.parent[node]]
            node = self.parent[node]
        return node

    def _join(self, nodes: Sequence[int]) -> None:
        for node in nodes[1:]:
            self.parent[self.find(node)] = self.find(nodes[0])

    def _join_components(self) -> None:
        """Join all that is declared in one component."""
        index = self.plant.variable_index
        events: dict[str, list[int]] = {}
        for number, event in enumerate(self.plant.events):
            events.setdefault(event.key, []).append(self.node(number))
        for component in self.plant.robot.components:
            named = [(VariableKind.LOCATION, component.name)]
            if component.behaviour is not None:
                named += [(VariableKind.DATA, v.key) for v in component.behaviour.variables]
            nodes = [index[name] for name in named if name in index]
            for communication in component.communications:
                nodes += events.get(communication.key, ())
            self._join(nodes)

    def _join_requirements(self) -> None:
        """Join what a requirement reads with its commands: warnings are about both."""
        for requirement in self.plant.robot.requirements:
            commands = [self.requests[key] for key in requirement.communications]
            self._join([*commands, *self._read(requirement.condition)])

    def _join_data(self) -> None:
        """Join a command with what the conditions of its data read: warnings are about both."""
        for provide in self.plant.robot.provides:
            command = self.requests.get(provide.communication)
            if command is not None and provide.condition is not None:
                self._join([command, *self._read(provide.condition)])

    def _join_messages(self) -> None:
        """Join the events of one message, the commands to one topic, and preferred commands."""
        for numbers in inputs(self.plant):
            self._join([self.node(number) for number in numbers])
        robot = self.plant.robot
        topics: dict[str, list[int]] = {}
        for key, command in self.requests.items():
            communication = robot.communications[key]
            if communication.kind is Kind.INCOMING:
                topics.setdefault(communication.identifier.lstrip("/"), []).append(command)
        for commands in topics.values():
            self._join(commands)
        for key, preferred in robot.yields_to.items():
            self._join([self.requests[other] for other in (key, *preferred)])

    def _read(self, condition: Expr) -> tuple[int, ...]:
        return support(self.plant, self.plant.view.expression(condition))


def _part(plant: Plant, group: _Group) -> Plant:
    number = {variable: place for place, variable in enumerate(group.variables)}
    return replace(
        plant,
        variables=tuple(plant.variables[variable] for variable in group.variables),
        events=tuple(_renumbered(plant.events[event], number) for event in group.events),
        invariants=tuple(plant.invariants[invariant] for invariant in group.invariants),
    )


def _renumbered(event: Event, number: Mapping[int, int]) -> Event:
    phase = event.phase
    return replace(
        event,
        phase=None if phase is None else replace(phase, variable=number[phase.variable]),
        automata=tuple(
            replace(
                automaton,
                variable=number[automaton.variable],
                edges=tuple(
                    replace(edge, updates=tuple((number[v], expr) for v, expr in edge.updates))
                    for edge in automaton.edges
                ),
            )
            for automaton in event.automata
        ),
    )


# --- combining -----------------------------------------------------------------------------------


def combined(plant: Plant, parts: Sequence[Supervisor]) -> Supervisor:
    """Return the supervisor of a plant from those of its parts; empty if one of them is."""
    events = {event.identity: (number, event) for number, event in enumerate(plant.events)}
    empty = [part for part in parts if part.empty]
    states = prod(part.controlled_states for part in parts)
    never: dict[str, Any] = {"expr": FALSE, "status": "never"} if empty else {}
    guards = [
        replace(guard, event=events[guard.event.identity][1], **never)
        for part in parts
        for guard in part.guards
    ]
    return Supervisor(
        plant=plant,
        engine="bdd" if any(part.engine == "bdd" for part in parts) else "dense",
        seconds=sum(part.seconds for part in parts),
        plant_states=prod(part.plant_states for part in parts),
        controlled_states=states,
        # A transition of one part is possible in every state of the others.
        controlled_transitions=sum(
            states // part.controlled_states * part.controlled_transitions
            for part in (() if empty else parts)
        ),
        guards=tuple(sorted(guards, key=lambda guard: events[guard.event.identity][0])),
        explanations=tuple(_explanations(empty or parts, events)),
        properties=() if empty else _properties(parts),
        diagnostics=tuple(dict.fromkeys(d for part in empty or parts for d in part.diagnostics)),
        empty=bool(empty),
        step_bound=None if empty else _step_bound(parts),
    )


def _explanations(
    parts: Iterable[Supervisor], events: Mapping[_Identity, tuple[int, Event]]
) -> list[Explanation]:
    """Return all explanations in the order of events, with the events of the whole plant."""

    def whole(event: Event | None) -> Event | None:
        return None if event is None else events[event.identity][1]

    def place(explanation: Explanation) -> int:
        event = explanation.event
        return -1 if event is None else events[event.identity][0]

    found = [
        replace(
            explanation,
            event=whole(explanation.event),
            trace=tuple(
                Step(events[step.event.identity][1], step.values) for step in explanation.trace
            ),
        )
        for part in parts
        for explanation in part.explanations
    ]
    return sorted(found, key=place)


def _properties(parts: Sequence[Supervisor]) -> tuple[tuple[str, bool], ...]:
    """Return what holds in all parts, and what fails in one; the rest is unknown and left out."""
    of_parts = [dict(part.properties) for part in parts]
    names = dict.fromkeys(name for properties in of_parts for name in properties)
    found: list[tuple[str, bool]] = []
    for name in names:
        answers = [properties.get(name) for properties in of_parts]
        if False in answers or None not in answers:
            found.append((name, False not in answers))
    return tuple(found)


def _step_bound(parts: Iterable[Supervisor]) -> int | None:
    """Return the sum: at the start all parts run to completion, one after the other."""
    total = 0
    for part in parts:
        if part.step_bound is None:
            return None
        total += part.step_bound
    return total
