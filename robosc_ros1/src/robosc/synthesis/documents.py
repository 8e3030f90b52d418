"""The JSON documents of ``synthesize`` and ``explore``, version 1."""

from __future__ import annotations

import json
from collections.abc import Iterable, Iterator, Sequence
from itertools import islice
from typing import Any

from robosc.expr.traversal import path_text
from robosc.expr.types import Value
from robosc.model.automata import HOLDING
from robosc.plant.automaton import Event, EventParameter, Plant, PlantState, VariableKind
from robosc.plant.model_text import to_dsl
from robosc.runtime.core.places import place_of, places, stages
from robosc.source import Span
from robosc.supervisor import Step, Supervisor
from robosc.synthesis.explore import Graph
from robosc.synthesis.listing import Listed, listed


def event_document(event: Event) -> dict[str, Any]:
    """Return the document of an event without its values; a tau with its number."""
    found: dict[str, Any] = {"kind": event.kind.word, "name": event.name}
    if event.kind.of_component:
        found["index"] = event.index
    return found


def step_document(step: Step) -> dict[str, Any]:
    """Return the document of one occurrence of an event with its values."""
    event = step.event
    if event.kind.of_component:
        return {**event_document(event), "value": step.values[0] if step.values else None}
    return {**event_document(event), "value": _value(event.parameters, step.values)}


def synthesize_document(supervisor: Supervisor) -> dict[str, Any]:
    """Return the document of ``synthesize --json``.

    The ``short`` texts of long guards refer to the names in ``definitions``.
    """
    plant = supervisor.plant
    robot = plant.robot
    names = supervisor.part_names
    return {
        "version": 1,
        "robot": robot.name,
        "engine": supervisor.engine,
        "seconds": supervisor.seconds,
        "plant_states": supervisor.plant_states,
        "controlled_states": supervisor.controlled_states,
        "controlled_transitions": supervisor.controlled_transitions,
        "guards": [
            {
                "event": _any_value(plant, guard.event),
                "guard": to_dsl(guard.expr, robot),
                "short": to_dsl(names.of_guard(guard.expr), robot),
                "status": guard.status,
            }
            for guard in supervisor.guards
        ],
        "definitions": [
            {"name": part.name, "condition": part.text(robot)} for part in names.definitions
        ],
        "explanations": [
            {
                "event": None if found.event is None else _any_value(plant, found.event),
                "reason": found.reason,
                "trace": [step_document(step) for step in found.trace],
                "traced": found.traced,
                "remedy": found.remedy,
                "conflict": _conflict(found.conflict),
            }
            for found in supervisor.explanations
        ],
        "properties": dict(supervisor.properties),
        "free_tests": list(plant.view.free),
        "free_reasons": dict(plant.view.free),
    }


def _conflict(conflict: tuple[tuple[str, Span], ...] | None) -> list[dict[str, Any]] | None:
    """Return what conflicts; None if it was not looked for."""
    if conflict is None:
        return None
    return [{"text": t, "file": span.source.path, "line": span.line} for t, span in conflict]


def explore_json(graph: Graph, lines_at_once: int = 10_000) -> Iterator[str]:
    """Yield the text of ``explore --json`` in chunks, one state or transition per line."""
    plant = graph.plant
    head = {"version": 1, "robot": plant.robot.name, **_initial(graph)}
    yield json.dumps(head)[:-1] + ',\n "states": [\n'
    states = (_state(plant, number, state) for number, state in enumerate(graph.states))
    yield from _lines((json.dumps(state) for state in states), lines_at_once)
    yield '],\n "transitions": [\n'
    yield from _lines((json.dumps(_transition(one)) for one in listed(graph)), lines_at_once)
    yield "]}\n"


def _initial(graph: Graph) -> dict[str, Any]:
    """Return the initial state, and all of them where node parameters make several."""
    several = {"initials": list(range(graph.starts))} if graph.starts > 1 else {}
    return {"initial": 0, **several}


def _lines(texts: Iterable[str], at_once: int) -> Iterator[str]:
    """Yield texts, each on a line, separated by commas; ``at_once`` lines per chunk."""
    remaining = iter(texts)
    before = "  "
    while part := list(islice(remaining, at_once)):
        yield before + ",\n  ".join(part)
        before = ",\n  "
    yield "\n"


def _transition(listed: Listed) -> dict[str, Any]:
    """Return the document of a transition.

    ``any`` names parts of the value that do not matter, ``values`` is for how many it stands.
    """
    return {
        "source": listed.source,
        "event": step_document(listed.step),
        **({"any": [*listed.any], "values": listed.values} if listed.any else {}),
        "controllable": listed.step.event.controllable,
        "target": listed.target,
    }


def _any_value(plant: Plant, event: Event) -> dict[str, Any]:
    """Return a controllable event's document; a tau has a value if it has only one transition."""
    value = None
    if event.kind.of_component:
        automaton, *_ = event.automata
        ends = {(edge.source, edge.target) for edge in automaton.edges}
        names = plant.variables[automaton.variable].values
        if len(ends) == 1:
            value = "->".join(place_of(str(names[location])) for location in ends.pop())
    elif event.known:
        known = [event.parameters[i] for i in event.known]
        return {**event_document(event), "value": _value(known, [p.values[0] for p in known])}
    return {**event_document(event), "value": value}


def _state(plant: Plant, number: int, state: PlantState) -> dict[str, Any]:
    found: dict[VariableKind, dict[str, Any]] = {kind: {} for kind in VariableKind}
    for variable, value in zip(plant.variables, state, strict=True):
        found[variable.kind][variable.name] = variable.shown(value)
    for lasting in plant.robot.lasting:
        state_of = found[VariableKind.LOCATION].pop(lasting.name)
        found[VariableKind.DATA][lasting.name] = state_of == HOLDING
    states = found[VariableKind.LOCATION]
    shown = stages(states, plant.robot.stages)
    return {
        "id": number,
        "components": places(states),
        "variables": found[VariableKind.DATA] | shown | found[VariableKind.TEST],
        "communications": {
            plant.robot.display_names[key]: phase
            for key, phase in found[VariableKind.PHASE].items()
        },
        "marked": plant.is_marked(state),
    }


def _value(parameters: Sequence[EventParameter], values: Sequence[Value | None]) -> Any:
    if not parameters:
        return None
    if len(parameters) == 1 and parameters[0].path == ():
        return parameters[0].shown(values[0])
    return {
        path_text(parameter.path): parameter.shown(value)
        for parameter, value in zip(parameters, values, strict=True)
    }
