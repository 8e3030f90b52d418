"""Decomposition of a plant into independent parts that share no event, variable or requirement.

Parts are solved separately: the supervisor of the plant consists of those of its parts, its states
are the product of theirs, and an event of one part leaves the others unchanged. Components also
belong to one part if a warning could be about both of them (commands to one topic, the conditions
of provided data), or if the controller handles their events together: a message that both receive,
a command of one that is preferred to a command of the other.
"""

from __future__ import annotations

from collections.abc import Hashable, Iterable, Mapping, Sequence
from dataclasses import astuple, field, replace
from math import prod
from typing import TypeAlias

from robosc import dotted
from robosc.language.events import EventKind, Kind
from robosc.lazy_dataclasses import dataclass
from robosc.plant.automaton import Event, Plant, PlantGoal, VariableKind
from robosc.plant.data.disjoint_sets import DisjointSets
from robosc.plant.data.view import sent_wholes
from robosc.plant.support import event_support, step_support, support
from robosc.supervisor import Explanation, Step, Supervisor
from robosc.synthesis.controlled_system import inputs
from robosc.synthesis.result import nothing_allowed

_SMALL = 2**12
"""Product size up to which a part may be joined with others."""

_Identity: TypeAlias = tuple[EventKind, str, int]
"""What identifies an event of a plant: its kind, key and index."""


@dataclass(frozen=True, slots=True)
class _Group:
    """Variables, events, invariants, goals and lasting assumptions of a plant that belong together,
    by number."""

    variables: list[int] = field(default_factory=list)
    events: list[int] = field(default_factory=list)
    invariants: list[int] = field(default_factory=list)
    goals: list[int] = field(default_factory=list)
    lasting: list[int] = field(default_factory=list)

    def add(self, other: _Group) -> None:
        self.variables.extend(other.variables)
        self.events.extend(other.events)
        self.invariants.extend(other.invariants)
        self.goals.extend(other.goals)
        self.lasting.extend(other.lasting)


def independent_parts(plant: Plant, size: int) -> list[Plant]:
    """Return the independent parts of a plant, in model order; the plant itself if there is one.

    Small parts are joined up to a product of ``size`` combinations of values.
    """
    sets = _sets(plant)
    groups: dict[Hashable, _Group] = {}
    for variable in range(len(plant.variables)):
        groups.setdefault(sets.find(variable), _Group()).variables.append(variable)
    # What reads and writes no variable may be in any part: it goes to the first.
    first = next(iter(groups.values()), _Group())
    for number, event in enumerate(plant.events):
        groups.get(sets.find(event.identity), first).events.append(number)
    for number, (condition, _) in enumerate(plant.invariants):
        read = support(plant, condition)
        (groups[sets.find(read[0])] if read else first).invariants.append(number)
    for number, goal in enumerate(plant.goals):
        reads = _read_by(plant, goal)
        (groups[sets.find(reads[0])] if reads else first).goals.append(number)
    for number, (condition, _) in enumerate(plant.lasting):
        read = support(plant, condition)
        (groups[sets.find(read[0])] if read else first).lasting.append(number)
    bundles = _bundles(plant, groups.values(), size)
    return [plant] if len(bundles) < 2 else [_part(plant, bundle) for bundle in bundles]


def parts_without_requirements(plant: Plant) -> list[Plant]:
    """Return the parts of a plant that share no event and no variable, requirements left out."""
    sets = DisjointSets()
    for number in range(len(plant.variables)):
        sets.join([number])
    for event in plant.events:
        sets.join([event.identity, *step_support(plant, event)])
    alone = replace(
        plant,
        events=tuple(replace(e, requirement=None, requirements=()) for e in plant.events),
        invariants=(),
        goals=(),
        lasting=(),
    )
    groups: dict[Hashable, _Group] = {}
    for number in range(len(plant.variables)):
        groups.setdefault(sets.find(number), _Group()).variables.append(number)
    for number, event in enumerate(plant.events):
        if (group := groups.get(sets.find(event.identity))) is not None:
            group.events.append(number)
    return [_part(alone, group) for group in groups.values()]


def _bundles(plant: Plant, groups: Iterable[_Group], size: int) -> list[_Group]:
    """Return the groups, small neighbouring ones joined."""
    bundles: list[_Group] = []
    open_, total = _Group(), size + 1
    for group in groups:
        own = prod(plant.sizes(group.variables))
        if own > _SMALL:
            bundles.append(group)
            continue
        total *= own
        if total > size:
            bundles.append(open_ := _Group())
            total = own
        open_.add(group)
    return [_Group(*(sorted(numbers) for numbers in astuple(bundle))) for bundle in bundles]


def _sets(plant: Plant) -> DisjointSets:
    """Return which state variables (numbers), events, components and topics belong together."""
    sets = DisjointSets()
    robot = plant.robot

    def request(key: str) -> _Identity:
        command = robot.commands.get(key)
        return (
            (EventKind.REQUEST, key, 0)
            if command is None
            else (command.kind, command.communication.key, 0)
        )

    for number, variable in enumerate(plant.variables):
        if variable.kind is not VariableKind.TEST:
            sets.join([number, dotted.first(variable.name)])
    for event in plant.events:
        sets.join([event.identity, dotted.first(event.key), *event_support(plant, event)])
    for condition, _ in plant.invariants:
        sets.join(support(plant, condition))
    for condition, _ in plant.lasting:
        sets.join(support(plant, condition))
    for goal in plant.goals:
        sets.join(_read_by(plant, goal))
    # Warnings are about a command and what its requirements and the conditions of its data read.
    conditions = [(r.communications, r.condition) for r in robot.requirements]
    conditions += [((p.communication,), p.deciding) for p in robot.provides if p.deciding]
    for keys, condition in conditions:
        sets.join([*map(request, keys), *support(plant, plant.view.expression(condition))])
    # Others are about a command and the objects and arrays that it sends.
    for provide in robot.provides:
        for whole in sent_wholes(provide):
            there = support(plant, plant.view.is_there(whole))
            sets.join([request(provide.communication), *there])
    # The controller handles the events of one message together, and compares preferred commands.
    for numbers in inputs(plant):
        sets.join(plant.events[number].identity for number in numbers)
    for key, communication in robot.communications.items():
        if communication.kind is Kind.INCOMING:
            sets.join([request(key), ("topic", communication.ros_name)])
    for key, preferred in robot.yields_to.items():
        sets.join(map(request, (key, *preferred)))
    return sets


def _read_by(plant: Plant, goal: PlantGoal) -> list[int]:
    return [variable for expr in goal.conditions for variable in support(plant, expr)]


def _part(plant: Plant, group: _Group) -> Plant:
    number = {variable: place for place, variable in enumerate(group.variables)}
    return replace(
        plant,
        variables=tuple(plant.variables[variable] for variable in group.variables),
        events=tuple(_renumbered(plant.events[event], number) for event in group.events),
        invariants=tuple(plant.invariants[invariant] for invariant in group.invariants),
        goals=tuple(plant.goals[goal] for goal in group.goals),
        lasting=tuple(plant.lasting[number] for number in group.lasting),
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
    guards = [
        replace(guard, event=events[guard.event.identity][1])
        for part in parts
        for guard in part.guards
    ]
    guards.sort(key=lambda guard: events[guard.event.identity][0])
    return Supervisor(
        plant=plant,
        engine="bdd" if any(part.engine == "bdd" for part in parts) else "explicit",
        seconds=sum(part.seconds for part in parts),
        plant_states=prod(part.plant_states for part in parts),
        controlled_states=states,
        # A transition of one part is possible in every state of the others.
        controlled_transitions=sum(
            states // part.controlled_states * part.controlled_transitions
            for part in (() if empty else parts)
        ),
        guards=nothing_allowed(plant) if empty else tuple(guards),
        explanations=tuple(_explanations(empty or parts, events)),
        properties=() if empty else _properties(parts),
        diagnostics=tuple(dict.fromkeys(d for part in empty or parts for d in part.diagnostics)),
        empty=bool(empty),
        step_bound=None if empty else _step_bound(parts),
        opposite_order=any(part.opposite_order for part in parts),
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

    explanations = [
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
    return sorted(explanations, key=place)


def _properties(parts: Sequence[Supervisor]) -> tuple[tuple[str, bool], ...]:
    """Return what holds in all parts, and what fails in one; the rest is unknown and left out."""
    of_parts = [dict(part.properties) for part in parts]
    names = dict.fromkeys(name for properties in of_parts for name in properties)
    decided: list[tuple[str, bool]] = []
    for name in names:
        answers = [properties.get(name) for properties in of_parts]
        if False in answers or None not in answers:
            decided.append((name, False not in answers))
    return tuple(decided)


def _step_bound(parts: Iterable[Supervisor]) -> int | None:
    """Return the sum: at the start all parts run to completion, one after the other."""
    total = 0
    for part in parts:
        if part.step_bound is None:
            return None
        total += part.step_bound
    return total
