"""Plant and supervisor as one JSON document, for other programs (docs/export.md)."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

from robosc.ir.automaton import Axis, AxisKind, Edge, Event, Participant, Plant
from robosc.ir.expr import to_dsl
from robosc.model.expr import Expr, path_text
from robosc.supervisor import Supervisor
from robosc.synthesis.documents import synthesize_document

__all__ = ["export_document"]


def export_document(supervisor: Supervisor) -> dict[str, Any]:
    """``export --format json``, version 1. Expressions are texts in the language's own syntax."""
    plant = supervisor.plant
    synthesized = synthesize_document(supervisor)
    kept = ("engine", "plant_states", "controlled_states", "controlled_transitions", "guards")
    return {
        "version": 1,
        "robot": plant.robot.name,
        "plant": {
            "axes": [_axis(axis, plant) for axis in plant.axes],
            "events": [_event(event, plant) for event in plant.events],
            "invariants": [
                {"condition": to_dsl(expr, plant.robot), "requirement": index}
                for expr, index in plant.invariants
            ],
        },
        "requirements": [requirement.text for requirement in plant.robot.requirements],
        "supervisor": {
            "empty": supervisor.empty,
            **{name: synthesized[name] for name in kept},
        },
    }


def _axis(axis: Axis, plant: Plant) -> dict[str, Any]:
    marked = range(axis.size) if axis.marked is None else sorted(axis.marked)
    return {
        "kind": axis.kind.value,
        "name": _name(axis, plant),
        "values": list(axis.values),
        "initial": axis.values[axis.initial],
        "marked": [axis.values[index] for index in marked],
    }


def _name(axis: Axis, plant: Plant) -> str:
    if axis.kind is AxisKind.PHASE:
        return plant.robot.display_names[axis.name]
    return axis.name


def _event(event: Event, plant: Plant) -> dict[str, Any]:
    phase = None
    if event.phase is not None:
        axis = plant.axes[event.phase.axis]
        phase = {
            "name": _name(axis, plant),
            "source": axis.values[event.phase.source],
            "target": axis.values[event.phase.target],
        }
    return {
        "kind": event.kind.value,
        "name": event.name,
        "index": event.index,
        "controllable": event.controllable,
        "parameters": [
            {"path": path_text(p.path), "values": list(p.values)} for p in event.parameters
        ],
        "phase": phase,
        "participants": [_participant(p, plant) for p in event.participants],
        "requirement": _text(event.requirement, plant),
        "requirements": list(event.requirements),
    }


def _participant(participant: Participant, plant: Plant) -> dict[str, Any]:
    return {
        "component": participant.component,
        "blocking": participant.blocking,
        "edges": [_edge(edge, participant, plant) for edge in participant.edges],
    }


def _edge(edge: Edge, participant: Participant, plant: Plant) -> dict[str, Any]:
    locations = plant.axes[participant.axis].values
    return {
        "source": locations[edge.source],
        "guard": _text(edge.guard, plant),
        "updates": list(_updates(edge, plant)),
        "target": locations[edge.target],
    }


def _updates(edge: Edge, plant: Plant) -> Iterator[dict[str, Any]]:
    for axis, expr in edge.updates:
        yield {"variable": plant.axes[axis].name, "value": to_dsl(expr, plant.robot)}


def _text(expr: Expr | None, plant: Plant) -> str | None:
    return None if expr is None else to_dsl(expr, plant.robot)
