"""Explanation of a state from which no marked state, or not what must remain possible, can be
reached."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from itertools import product
from math import prod

from robosc.errors import listing
from robosc.expr.traversal import walk
from robosc.expr.tree import Expr, StateRef
from robosc.language.events import EventKind
from robosc.lazy_dataclasses import dataclass
from robosc.model.entities import Component, Requirement
from robosc.plant.automaton import Edge, Event, Plant, VariableKind
from robosc.plant.logic import conjunction
from robosc.plant.partial_evaluation import holds
from robosc.plant.support import support
from robosc.remedies import Change, Hint, Remedy
from robosc.source import Span
from robosc.supervisor import Step
from robosc.synthesis.compiled_steps import Stepper
from robosc.synthesis.controlled_system import location_name
from robosc.synthesis.formatting import quoted
from robosc.synthesis.guards.greedy_selection import drop

_MOST_VALUES = 2**12
"""Combinations of values for which it is tried whether requirements can hold."""


@dataclass(frozen=True, slots=True)
class Cause:
    """Why a state is bad, what to do about it, and the place in the model."""

    reason: str
    remedy: Hint | None = None
    span: Span | None = None


def why_blocked(
    plant: Plant, values: Sequence[frozenset[int]], steps: Callable[[], Sequence[Step]]
) -> Cause:
    """Return why no marked state can be reached from a state.

    ``values`` are those that each state variable may still have; ``steps`` computes the trace to
    the state: a component may be stuck because it does not react to one of its last events.
    """
    marking = [
        (number, variable.marked)
        for number, variable in enumerate(plant.variables)
        if variable.marked is not None
    ]
    stuck = [number for number, marked in marking if marked.isdisjoint(values[number])]
    if not stuck:
        names = [plant.variables[n].name for n, marked in marking if not marked >= values[n]]
        return Cause(f"{listing(names)} are never in marked states at the same time again")
    stuck.sort(key=lambda n: plant.variables[n].kind is VariableKind.PHASE)
    trace = steps()
    causes = [_of_variable(plant, trace, values, variable) for variable in stuck]
    # A component that lacks a transition comes before one that others block.
    return next((cause for cause in causes if isinstance(cause.remedy, Remedy)), causes[0])


def why_impossible(plant: Plant, goal: int) -> Cause:
    """Return that what must remain possible is not, whatever the controller does."""
    written = plant.robot.goals[plant.goals[goal].index]
    there, *_ = plant.goals[goal].conditions
    reason = f"{quoted(written.text)} fails: it is out of reach"
    return Cause(reason, _never_entered(plant, there), written.span)


def _never_entered(plant: Plant, condition: Expr) -> str | None:
    """Return that no transition leads to a state that a condition names, if that is so."""
    named = {
        (p.component, s): p for p in walk(condition) if isinstance(p, StateRef) for s in p.places
    }
    for number, variable in enumerate(plant.variables):
        if variable.kind is not VariableKind.LOCATION:
            continue
        automata = [a for event in plant.events for a in event.automata if a.variable == number]
        entered = {edge.target for a in automata for edge in a.edges if edge.target != edge.source}
        for place, value in enumerate(variable.values):
            part = named.get((variable.name, str(value)))
            if part is not None and place not in entered | {variable.initial}:
                return (
                    f"nothing leads to state {part.state} of {part.component}: add a transition, as"
                    f" in 'goto {part.state}'"
                )
    return None


def _of_variable(
    plant: Plant, steps: Sequence[Step], values: Sequence[frozenset[int]], variable: int
) -> Cause:
    places = sorted(values[variable])
    names = list(dict.fromkeys(location_name(plant, variable, place) for place in places))
    name = plant.variables[variable].name
    if plant.variables[variable].kind is VariableKind.PHASE:
        return _of_phase(plant, name)
    if len(names) > 1:
        reason = f"{name} never gets back to a marked state (it stays in {listing(names, 'or')})"
        remedy = _by_error(plant, steps, variable, places)
        span = plant.robot.component(name).span
        return _with_unmet(plant, values, variable, Cause(reason, remedy, span))
    place, *_ = places
    reason = f"{name} is stuck in {name}.{names[0]}, from where no marked state can be reached"
    advice = _remedy(plant, steps, variable, place) or _of_others(plant, values, variable, place)
    span = plant.robot.component(name).states[place].span
    return _with_unmet(plant, values, variable, Cause(reason, advice, span))


def _of_phase(plant: Plant, key: str) -> Cause:
    name = plant.robot.display_names[key]
    if not plant.robot.communications[key].sort.served:
        return Cause(f"{name} stays busy forever")
    remedy = (
        f"let a component answer wherever it is: 'on response to {name}', or 'on error to {name}',"
        " which no requirement restricts"
    )
    reason = f"{name} is not answered any more: whoever called waits forever"
    return Cause(reason, remedy, plant.robot.communications[key].span)


def _remedy(plant: Plant, steps: Sequence[Step], variable: int, place: int) -> Hint | None:
    component = plant.robot.component(plant.variables[variable].name)
    name, here = component.declared, location_name(plant, variable, place)
    back = plant.variables[variable].initial
    for step in reversed(steps):
        event = step.event
        edges = _edges(event, variable, place)
        if event.kind in (EventKind.CALL, EventKind.RECALL):
            if remedy := _by_error(plant, [step], variable, [place]):
                return remedy
            continue
        synchronised = event.kind.synchronised and edges
        if event.kind is EventKind.REQUEST or event.kind.of_component or synchronised:
            continue
        origin = _requested_from(plant, event.key, variable, place)
        if origin is not None and _leaving_by(plant, event.key, variable, place):
            target = location_name(plant, variable, origin)
            direction = "to" if event.kind.to_component else "from"
            happens = f"on {event.kind.word} {direction} {written(plant, event, component)}"
            own = component.states[place].on_communications
            has_own = any(t.event is event.kind and t.communication == event.key for t in own)
            always = any(edge.guard is None for edge in edges)
            if always and any(edge.target != place for edge in edges):
                continue
            if always and has_own:
                return f"let '{happens}' in state {here} of {name} lead on: 'goto {target}'"
            transition = f"{happens} {'else ' if has_own else ''}goto {target}"
            added = f"add '{transition}'"
            if edges and not always and not has_own:
                return f"{added} outside the states of {name}, for when none of the guards holds"
            text = f"{added} in state {here} of {name}"
            return Remedy(text, Change.ADD_TRANSITION, (transition, here, name))
    leaving = [
        event
        for event in plant.events
        if any(edge.target != place for edge in _edges(event, variable, place))
    ]
    if not leaving:
        target = location_name(plant, variable, back)
        return f"nothing leaves state {here} of {name}: add a transition, as in 'goto {target}'"
    return None


def _of_others(
    plant: Plant, values: Sequence[frozenset[int]], variable: int, place: int
) -> str | None:
    """Return which component blocks, in all states, a command that would lead away from here."""
    for event in plant.events:
        if not event.kind.sent or not any(
            e.target != place for e in _edges(event, variable, place)
        ):
            continue
        for automaton in event.automata:
            sources = {edge.source for edge in automaton.edges}
            found = sorted(values[automaton.variable])
            if automaton.variable == variable or not automaton.blocking or sources & {*found}:
                continue
            names = {location_name(plant, automaton.variable, there): None for there in found}
            where = listing([f"{automaton.component}.{name}" for name in names], "or")
            return (
                f"{event.name}.{event.kind.word} would lead on, but {automaton.component} does not"
                f" take it in {where}: write a transition for it there, or leave out those that"
                f" {automaton.component} has"
            )
    return None


def _with_unmet(
    plant: Plant, values: Sequence[frozenset[int]], variable: int, cause: Cause
) -> Cause:
    """Return a cause without a remedy with the requirements that forbid a component, for good, a
    command that it waits for."""
    if cause.remedy is not None:
        return cause
    for event in plant.events:
        waiting = (_edges(event, variable, place) for place in values[variable])
        if event.kind.sent and any(waiting) and (unmet := _unmet(plant, values, event)):
            texts = listing([quoted(requirement.text) for requirement in unmet])
            together = " together" if len(unmet) > 1 else ""
            remedy = (
                f"{event.name}.{event.kind.word} would lead on, but {texts} cannot hold{together}"
                " from there on: correct one of the conditions"
            )
            return Cause(cause.reason, remedy, unmet[0].span)
    return cause


def _unmet(plant: Plant, values: Sequence[frozenset[int]], event: Event) -> Sequence[Requirement]:
    """Return requirements of a command that never hold together for some values of the state
    variables, none of them superfluous; nothing if they do, or if there are too many values."""
    stepper = Stepper(plant)

    def never_met(requirements: Sequence[Requirement]) -> bool:
        test = conjunction(holds(plant.view.met(each), event.data) for each in requirements)
        read = support(plant, test)
        if prod(len(values[variable]) for variable in read) > _MOST_VALUES:
            return False
        state, is_met = [min(found) for found in values], stepper.test(test)
        for chosen in product(*(values[variable] for variable in read)):
            for variable, value in zip(read, chosen, strict=True):
                state[variable] = value
            if is_met(tuple(state)):
                return False
        return True

    def without(
        left: Sequence[Requirement], some: Sequence[Requirement]
    ) -> Sequence[Requirement] | None:
        fewer = [requirement for requirement in left if requirement not in some]
        return fewer if never_met(fewer) else None

    found = [plant.robot.requirements[number] for number in event.requirements]
    return drop(found, found, without) if found and never_met(found) else []


def written(plant: Plant, event: Event, component: Component) -> str:
    """Return the name that the communication of an event has where a component is declared."""
    communication = plant.robot.communications.get(event.key)
    if communication is None or communication.component != component.name:
        return event.name
    return communication.name


def _by_error(
    plant: Plant, steps: Sequence[Step], variable: int, places: Sequence[int]
) -> str | None:
    """Return how a component may end, in some places, the call of the robot that was made last."""
    component = plant.robot.component(plant.variables[variable].name)
    for event in (step.event for step in reversed(steps)):
        if event.kind not in (EventKind.CALL, EventKind.RECALL):
            continue
        origin = _requested_from(plant, event.key, variable, places[0])
        if origin is not None and origin not in places:
            names = {location_name(plant, variable, place): None for place in places}
            here = ("state " if len(names) == 1 else "states ") + listing(names)
            target = location_name(plant, variable, origin)
            return (
                f"add 'on error to {written(plant, event, component)} if … goto {target}' in {here}"
                f" of {component.declared}: no requirement restricts an error, and it is sent"
                " wherever it is possible"
            )
    return None


def _requested_from(plant: Plant, key: str, variable: int, place: int) -> int | None:
    """Return the state from which a request led the component here, else its initial one.

    An error leads back there, not to where a response does: nothing has been achieved.
    """
    sources = [
        edge.source
        for event in plant.events
        if event.key == key and event.kind in (EventKind.REQUEST, EventKind.CALL)
        for automaton in event.automata
        if automaton.variable == variable
        for edge in automaton.edges
        if edge.target == place
    ]
    found = (state for state in (*sources, plant.variables[variable].initial) if state != place)
    return next(found, None)


def _edges(event: Event, variable: int, place: int) -> list[Edge]:
    """Return the edges of an event from a location (``place``) of a component (``variable``)."""
    return [
        edge
        for automaton in event.automata
        if automaton.variable == variable
        for edge in automaton.edges
        if edge.source == place
    ]


def _leaving_by(plant: Plant, key: str, variable: int, place: int) -> list[Edge]:
    """Return the edges that leave a location by an event of a communication."""
    return [
        edge
        for event in plant.events
        if event.key == key and not event.kind.of_component
        for edge in _edges(event, variable, place)
        if edge.target != place
    ]
