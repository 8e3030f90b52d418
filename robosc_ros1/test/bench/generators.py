"""A plant as classical automata: what a tool of supervisory control theory is given.

A component becomes an automaton over its location and variables, the phase of a service or action
one of two states, and each conjunct of a requirement an automaton that observes the components it
reads and allows the command where it holds. An event with a value becomes one event per value. What
may leave a range is a specification: there, too, an event that must not happen is simply missing.

Only for plants whose components read nothing of each other but in requirements.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator
from dataclasses import dataclass, replace

from robosc.expr.traversal import walk
from robosc.expr.tree import TRUE, Binary, Expr, StateRef, Unary, VariableRef
from robosc.plant.automaton import Event, Plant, PlantState, VariableKind
from robosc.plant.logic import negation
from robosc.plant.step import Verdict, holds, outcome, valuations

__all__ = ["Automaton", "Automata", "automata_of"]

_Local = tuple[int, ...]


@dataclass(frozen=True)
class Automaton:
    """States are numbered from 0, which is the initial one; ``events`` are labels."""

    states: int
    marked: frozenset[int]
    events: frozenset[str]
    transitions: tuple[tuple[int, str, int], ...]


@dataclass(frozen=True)
class Automata:
    plant: tuple[Automaton, ...]
    specification: tuple[Automaton, ...]
    controllable: dict[str, bool]


@dataclass(frozen=True)
class _Component:
    """An automaton with the values of its state variables in each state."""

    variables: tuple[int, ...]
    places: tuple[_Local, ...]
    automaton: Automaton
    leaves_range: bool


def automata_of(plant: Plant) -> Automata:
    labels = {
        id(event): [f"e{number}_{n}" for n, _ in enumerate(valuations(event))]
        for number, event in enumerate(plant.events)
    }
    components = {
        variable.name: _component(plant, variable.name, labels)
        for variable in plant.variables
        if variable.kind is VariableKind.LOCATION
    }
    automata = [c.automaton for c in components.values() if not c.leaves_range]
    specification = [c.automaton for c in components.values() if c.leaves_range]
    automata += [
        _phase(plant, number, labels)
        for number, variable in enumerate(plant.variables)
        if variable.kind is VariableKind.PHASE
    ]
    for event in plant.events:
        if event.phase is None and not event.automata:
            automata.append(_free(labels[id(event)]))
        for clause in _conjuncts(TRUE if event.requirement is None else event.requirement):
            if clause != TRUE:
                specification.append(_requirement(plant, clause, labels[id(event)], components))
    controllable = {
        label: event.controllable for event in plant.events for label in labels[id(event)]
    }
    # The plant has all events, also those of a component that is a specification; and there is one.
    told = frozenset[str]().union(*(automaton.events for automaton in automata))
    if unknown := [label for label in controllable if label not in told]:
        automata.append(_free(unknown))
    if not specification:
        specification.append(_free(list(controllable)))
    return Automata(tuple(automata), tuple(specification), controllable)


def _component(plant: Plant, name: str, labels: dict[int, list[str]]) -> _Component:
    variables = tuple(
        number
        for number, variable in enumerate(plant.variables)
        if variable.kind is not VariableKind.PHASE and variable.name.split(".")[0] == name
    )
    alone: list[tuple[Event, list[str]]] = []
    for event in plant.events:
        own = tuple(p for p in event.automata if p.component == name)
        if own:
            alone.append((replace(event, automata=own, phase=None), labels[id(event)]))
    places = [tuple(plant.variables[variable].initial for variable in variables)]
    number = {places[0]: 0}
    transitions = []
    leaves_range = False
    for place in places:  # grows while it is walked
        state = _state(plant, variables, place)
        for event, names in alone:
            for label, values in zip(names, valuations(event), strict=True):
                after = outcome(plant, event, values, state)
                if isinstance(after, Verdict):
                    leaves_range |= after is Verdict.OUT_OF_RANGE and not event.controllable
                    continue
                target = tuple(after[variable] for variable in variables)
                if target not in number:
                    number[target] = len(places)
                    places.append(target)
                transitions.append((number[place], label, number[target]))
    location = plant.variables[variables[0]]
    assert location.marked is not None
    marked = frozenset(n for n, place in enumerate(places) if place[0] in location.marked)
    events = frozenset(label for _, names in alone for label in names)
    automaton = Automaton(len(places), marked, events, tuple(transitions))
    return _Component(variables, tuple(places), automaton, leaves_range)


def _state(plant: Plant, variables: Iterable[int], place: _Local) -> PlantState:
    state = list(plant.initial)
    for variable, value in zip(variables, place, strict=True):
        state[variable] = value
    return tuple(state)


def _phase(plant: Plant, variable: int, labels: dict[int, list[str]]) -> Automaton:
    transitions = []
    for event in plant.events:
        if event.phase is not None and event.phase.variable == variable:
            step = event.phase
            transitions += [
                (source, label, step.target)
                for source in step.sources
                for label in labels[id(event)]
            ]
    events = frozenset(label for _, label, _ in transitions)
    phases = plant.variables[variable]
    marked = frozenset(range(phases.size)) if phases.marked is None else phases.marked
    return Automaton(phases.size, marked, events, tuple(transitions))


def _free(labels: list[str]) -> Automaton:
    return Automaton(1, frozenset({0}), frozenset(labels), tuple((0, label, 0) for label in labels))


def _conjuncts(expr: Expr) -> Iterator[Expr]:
    match expr:
        case Binary(operator="and", left=left, right=right):
            yield from _conjuncts(left)
            yield from _conjuncts(right)
        case Unary(operator="!", operand=Binary(operator="or", left=left, right=right)):
            yield from _conjuncts(negation(left))
            yield from _conjuncts(negation(right))
        case _:
            yield expr


def _requirement(
    plant: Plant, clause: Expr, labels: list[str], components: dict[str, _Component]
) -> Automaton:
    read = dict.fromkeys(
        node.component for node in walk(clause) if isinstance(node, StateRef | VariableRef)
    )
    parts = [components[name] for name in read]
    variables = tuple(variable for part in parts for variable in part.variables)

    def allows(place: tuple[int, ...]) -> bool:
        local = tuple(v for part, n in zip(parts, place, strict=True) for v in part.places[n])
        return holds(plant, clause, _state(plant, variables, local))

    return _observer([part.automaton for part in parts], frozenset(labels), allows)


def _observer(
    automata: list[Automaton], commands: frozenset[str], allows: Callable[[tuple[int, ...]], bool]
) -> Automaton:
    """The automata side by side; the commands only in some of their states."""
    steps = [
        {(source, label): target for source, label, target in one.transitions} for one in automata
    ]
    labels = commands.union(*(one.events for one in automata))
    places = [(0,) * len(automata)]
    number = {places[0]: 0}
    transitions = []
    for place in places:  # grows while it is walked
        for label in sorted(labels):
            if label in commands and not allows(place):
                continue
            after: list[int] = []
            for at, one, step in zip(place, automata, steps, strict=True):
                if label not in one.events:
                    after.append(at)
                elif (at, label) in step:
                    after.append(step[at, label])
            if len(after) < len(place):
                continue
            target = tuple(after)
            if target not in number:
                number[target] = len(places)
                places.append(target)
            transitions.append((number[place], label, number[target]))
    return Automaton(len(places), frozenset(range(len(places))), labels, tuple(transitions))
