"""Plant and supervisor as one JSON document, for other programs (docs/export.md)."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

from robosc.expr import traversal, tree
from robosc.plant.automaton import Edge, Event, LocalAutomaton, Plant, StateVariable, VariableKind
from robosc.plant.model_text import to_dsl
from robosc.supervisor import Supervisor
from robosc.synthesis.documents import synthesize_document


def export_document(supervisor: Supervisor) -> dict[str, Any]:
    """``export --format json``, version 1. Expressions are texts in the language's own syntax."""
    plant = supervisor.plant
    assumptions = plant.robot.assumptions
    synthesized = synthesize_document(supervisor)
    sizes = ("plant_states", "controlled_states", "controlled_transitions")
    kept = ("engine", *sizes, "guards", "definitions")
    return {
        "version": 1,
        "robot": plant.robot.name,
        "plant": {
            "variables": [_variable(variable, plant) for variable in plant.variables],
            "events": [_event(event, plant) for event in plant.events],
            "invariants": [
                {"condition": to_dsl(expr, plant.robot), "requirement": index}
                for expr, index in plant.invariants
            ],
        },
        "requirements": [requirement.text for requirement in plant.robot.requirements],
        **({"assumptions": [a.text for a in assumptions]} if assumptions else {}),
        **({"possible": [goal.text for goal in plant.robot.goals]} if plant.robot.goals else {}),
        "supervisor": {
            "empty": supervisor.empty,
            **{name: synthesized[name] for name in kept},
        },
    }


def _variable(variable: StateVariable, plant: Plant) -> dict[str, Any]:
    marked = range(variable.size) if variable.marked is None else sorted(variable.marked)
    return {
        "kind": variable.kind.value,
        "name": _name(variable, plant),
        "values": [variable.shown(index) for index in range(variable.size)],
        "initial": variable.shown(variable.initial),
        "initials": [variable.shown(index) for index in variable.start_indexes],
        "marked": [variable.shown(index) for index in marked],
    }


def _name(variable: StateVariable, plant: Plant) -> str:
    if variable.kind is VariableKind.PHASE:
        return plant.robot.display_names[variable.name]
    return variable.name


def _event(event: Event, plant: Plant) -> dict[str, Any]:
    phase = None
    if event.phase is not None:
        variable = plant.variables[event.phase.variable]
        phase = {
            "name": _name(variable, plant),
            "sources": [variable.values[source] for source in event.phase.sources],
            "target": variable.values[event.phase.target],
        }
    return {
        "kind": event.kind.word,
        "name": event.name,
        "index": event.index,
        "controllable": event.controllable,
        "parameters": [
            {"path": traversal.path_text(p.path), "values": [p.shown(value) for value in p.values]}
            for p in event.parameters
        ],
        "phase": phase,
        "automata": [_automaton(p, plant) for p in event.automata],
        "requirement": _text(event.requirement, plant),
        "requirements": list(event.requirements),
    }


def _automaton(automaton: LocalAutomaton, plant: Plant) -> dict[str, Any]:
    return {
        "component": automaton.component,
        "blocking": automaton.blocking,
        "edges": [_edge(edge, automaton, plant) for edge in automaton.edges],
    }


def _edge(edge: Edge, automaton: LocalAutomaton, plant: Plant) -> dict[str, Any]:
    locations = plant.variables[automaton.variable].values
    return {
        "source": locations[edge.source],
        "guard": _text(edge.guard, plant),
        "updates": list(_updates(edge, plant)),
        "target": locations[edge.target],
    }


def _updates(edge: Edge, plant: Plant) -> Iterator[dict[str, Any]]:
    for variable, expr in edge.updates:
        yield {"variable": plant.variables[variable].name, "value": to_dsl(expr, plant.robot)}


def _text(expr: tree.Expr | None, plant: Plant) -> str | None:
    return None if expr is None else to_dsl(expr, plant.robot)
