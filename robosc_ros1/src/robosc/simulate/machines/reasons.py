"""Why the supervisor does not enable a command, in a state of the plant."""

from __future__ import annotations

from collections.abc import Iterator

from robosc.emit.controller.naming import place
from robosc.errors import listing
from robosc.expr import evaluation, tree, types
from robosc.language.events import EventKind
from robosc.plant.automaton import Event, Plant, PlantState
from robosc.plant.conjuncts import Conjunct, conjuncts
from robosc.plant.event_values import values_read
from robosc.plant.step import Verdict, holds, is_true, lookup, outcome, taken_edge, valuations
from robosc.runtime.core.places import told_with_stage
from robosc.runtime.core.reasons import UNEXPLAINED, failure_text
from robosc.runtime.core.values import Undefined
from robosc.simulate.machines.machine import Reason
from robosc.simulate.machines.state import SystemState
from robosc.supervisor import Guard, Supervisor


def reasons(
    supervisor: Supervisor, guard: Guard, state: PlantState, data: SystemState
) -> tuple[Reason, ...]:
    """Everything that stands in the way of a controllable event; empty if it is enabled.

    ``data`` is the same state with the values of its data, as far as they are known.
    """
    plant = supervisor.plant
    event = guard.event
    found = list(_from_plant(supervisor, event, state))
    if holds(plant, guard.expr, state):
        return tuple(found)
    if event.kind is EventKind.CANCEL and not (
        event.requirement is not None and holds(plant, event.requirement, state)
    ):
        return (*found, *_kept(supervisor, event))
    violated = list(_violated(supervisor, event, state, data))
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
                where = str(plant.variables[automaton.variable].values[state[automaton.variable]])
                text = f"blocked by {automaton.component} in {told_with_stage(where)}"
                yield Reason("synchronisation", text)


def _violated(
    supervisor: Supervisor, event: Event, state: PlantState, data: SystemState
) -> Iterator[Reason]:
    if not event.kind.sent:
        return
    plant = supervisor.plant
    for index in event.requirements:
        requirement = plant.robot.requirements[index]
        if not _may_hold(plant, event, plant.view.met(requirement), state):
            because = [
                failure_text(part.failure, _known(part, data))
                for part in conjuncts(requirement, plant.robot)
                if _may_hold(plant, event, plant.view.expression(part.unmet), state)
            ]
            told = [text for text in because if text]
            yield Reason("requirement", requirement.text, place(requirement.span), told)


def _may_hold(plant: Plant, event: Event, condition: tree.Expr, state: PlantState) -> bool:
    """Whether a condition holds in a state, of data with one of the values that they have in this
    case of the event; of what the plant does not know of them, it does not.
    """
    parts = {parameter.path for parameter in event.parameters}
    if not all(path in parts for path in values_read([condition])):
        return False
    return any(
        is_true(condition, lookup(plant, event, values, state)) for values in valuations(event)
    )


def _known(part: Conjunct, data: SystemState) -> dict[str, types.Value]:
    """The values that a part compares, if its data are all known, and do not hold either.

    Of a test, a single event may have chosen what it came to, without any value.
    """
    try:
        values = {name: evaluation.evaluate(expr, data.look) for name, expr in part.values.items()}
        return values if is_true(part.unmet, data.look) else {}
    except Undefined:
        return {}


def _explained(supervisor: Supervisor, event: Event) -> str:
    found = [e.reason for e in supervisor.explanations if e.event == event]
    return listing(found) if found else UNEXPLAINED
