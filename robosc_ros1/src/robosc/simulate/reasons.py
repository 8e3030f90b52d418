"""Why the supervisor does not enable a command, in a state of the plant."""

from __future__ import annotations

from collections.abc import Iterator

from robosc.emit.controller.naming import place
from robosc.errors import listing
from robosc.language.events import EventKind
from robosc.plant.automaton import Event, PlantState
from robosc.plant.conjuncts import conjuncts
from robosc.plant.step import Verdict, holds, lookup, outcome, taken_edge, valuations
from robosc.runtime.reasons import UNEXPLAINED
from robosc.simulate.machine import Reason
from robosc.supervisor import Guard, Supervisor


def reasons(supervisor: Supervisor, guard: Guard, state: PlantState) -> tuple[Reason, ...]:
    """Everything that stands in the way of a controllable event; empty if it is enabled."""
    plant = supervisor.plant
    event = guard.event
    found = list(_from_plant(supervisor, event, state))
    if holds(plant, guard.expr, state):
        return tuple(found)
    if event.kind is EventKind.CANCEL and not (
        event.requirement is not None and holds(plant, event.requirement, state)
    ):
        return (*found, *_kept(supervisor, event))
    violated = list(_violated(supervisor, event, state))
    if violated or found:
        return (*found, *violated)
    return (Reason("synthesis", _explained(supervisor, event)),)


def _kept(supervisor: Supervisor, event: Event) -> Iterator[Reason]:
    """An action is cancelled only for a requirement that is violated."""
    for index in event.requirements:
        requirement = supervisor.plant.robot.requirements[index]
        yield Reason(
            "requirement", f"this requirement holds: {requirement.text}", place(requirement.span)
        )
    if not event.requirements:
        yield Reason("requirement", "no requirement is a reason to cancel it")


def _from_plant(supervisor: Supervisor, event: Event, state: PlantState) -> Iterator[Reason]:
    plant = supervisor.plant
    if event.phase is not None and state[event.phase.variable] not in event.phase.sources:
        phase = plant.variables[event.phase.variable].values[state[event.phase.variable]]
        yield Reason("phase", f"it is {phase}")
    # Whether the plant can do it does not hang on what the environment makes of it.
    values = next(valuations(event))
    after = outcome(plant, event, values, state)
    if after is Verdict.OUT_OF_RANGE:
        yield Reason("range", "a variable would leave its range")
    elif after is Verdict.IMPOSSIBLE:
        look = lookup(plant, event, values, state)
        for automaton in event.automata:
            if automaton.blocking and taken_edge(automaton, state, look) is None:
                where = plant.variables[automaton.variable].values[state[automaton.variable]]
                yield Reason("synchronisation", f"blocked by {automaton.component} in {where}")


def _violated(supervisor: Supervisor, event: Event, state: PlantState) -> Iterator[Reason]:
    if not event.kind.sent:
        return
    plant = supervisor.plant
    for index in event.requirements:
        requirement = plant.robot.requirements[index]
        if not holds(plant, plant.view.met(requirement), state):
            because = [
                part.failure
                for part in conjuncts(requirement, plant.robot)
                if part.failure and holds(plant, plant.view.expression(part.unmet), state)
            ]
            yield Reason("requirement", requirement.text, place(requirement.span), because)


def _explained(supervisor: Supervisor, event: Event) -> str:
    found = [e.reason for e in supervisor.explanations if e.event == event]
    return listing(found) if found else UNEXPLAINED
