"""Results as people read them, and the diagnostics as programs do (CLI.md)."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from typing import TYPE_CHECKING, Any

from robosc.errors import Diagnostic, sort_diagnostics
from robosc.ir.automaton import AxisKind, Plant, PlantState
from robosc.ir.expr import to_dsl
from robosc.model.entities import EventKind
from robosc.supervisor import Explanation, Guard, Step, Supervisor
from robosc.synthesis.documents import path_text, tau_values

if TYPE_CHECKING:
    from robosc.synthesis.explore import Graph

__all__ = ["diagnostics", "event_text", "graph_text", "supervisor_text"]

Document = dict[str, Any]


def diagnostics(found: Iterable[Diagnostic]) -> Document:
    """``check --json``."""
    return {
        "version": 1,
        "diagnostics": [
            {
                "file": d.span.source.path,
                "line": d.span.line,
                "column": d.span.column,
                "endLine": d.span.end_line,
                "endColumn": d.span.end_column,
                "severity": d.severity.value,
                "code": d.code,
                "message": d.message,
                "hint": d.hint,
            }
            for d in sort_diagnostics(found)
        ],
    }


# --- events --------------------------------------------------------------------------------------


def event_text(taken: Step) -> str:
    """``distance.response(free)``, ``Door.tau 2 (open->shut)``."""
    event = taken.event
    if event.kind is EventKind.TAU:
        way = f" ({taken.values[0]})" if taken.values else ""
        return f"{event.name}.tau {event.index}{way}"
    shown = []
    for parameter, value in zip(event.parameters, taken.values, strict=False):
        text = "nothing" if value is None else _value(value)
        shown.append(text if parameter.path == () else f"{path_text(parameter.path)} = {text}")
    values = f"({', '.join(shown)})" if shown else ""
    return f"{event.name}.{event.kind.value}{values}"


def _value(value: object) -> str:
    return str(value).lower() if isinstance(value, bool) else str(value)


# --- synthesize ----------------------------------------------------------------------------------


def supervisor_text(result: Supervisor) -> str:
    """Sizes, guards and reasons for people."""
    return "\n".join(_supervisor_lines(result)) + "\n"


def _supervisor_lines(result: Supervisor) -> Iterator[str]:
    yield sizes(result)
    width = max((len(event_text(Step(g.event))) for g in result.guards), default=0)
    for guard in result.guards:
        yield from _guard_lines(guard, width, result)
    for explanation in result.explanations:
        yield from _explanation_lines(explanation)
    if result.properties:
        yield ""
        for name, holds in result.properties:
            yield f"{name}: {'yes' if holds else 'no'}"


def sizes(result: Supervisor) -> str:
    return (
        f"{result.plant.robot.name}: {result.controlled_states:,} of {result.plant_states:,} states"
        f" under control, {result.controlled_transitions:,} transitions"
        f" ({result.engine} engine, {result.seconds:.2f} s)"
    )


def _guard_lines(guard: Guard, width: int, result: Supervisor) -> Iterator[str]:
    yield ""
    yield f"{event_text(Step(guard.event)):{width}}  {guard.status}"
    yield f"    {to_dsl(guard.expr, result.plant.robot)}"


def _explanation_lines(explanation: Explanation) -> Iterator[str]:
    name = "the supervisor" if explanation.event is None else event_text(Step(explanation.event))
    yield ""
    yield f"{name}: {explanation.reason}"
    if explanation.trace:
        yield f"    trace: {', '.join(event_text(taken) for taken in explanation.trace)}"
    if explanation.remedy:
        yield f"    remedy: {explanation.remedy}"


# --- explore -------------------------------------------------------------------------------------


def graph_text(system: Graph) -> str:
    """Each state with the steps out of it; ``*`` marks marked states, ``!`` controllable events."""
    plant = system.plant
    steps: list[list[str]] = [[] for _ in system.states]
    for t in system.transitions:
        event = plant.events[t.event]
        values = t.values
        if event.kind is EventKind.TAU:
            values = tau_values(plant, event, system.states[t.source], system.states[t.target])
        sign = "!" if event.controllable else " "
        steps[t.source].append(f"    {sign} {event_text(Step(event, values))} -> {t.target}")
    size = f"{len(system.states):,} states, {len(system.transitions):,} transitions"
    lines = [f"{plant.robot.name}: {size}"]
    for number, state in enumerate(system.states):
        values = ", ".join(_axis_texts(plant, state))
        lines.append(f"{number}{'*' if plant.is_marked(state) else ''}  {values}")
        lines += steps[number]
    return "\n".join(lines) + "\n"


def _axis_texts(plant: Plant, state: PlantState) -> Iterator[str]:
    for axis, index in zip(plant.axes, state, strict=True):
        value = _value(axis.values[index])
        match axis.kind:
            case AxisKind.LOCATION:
                yield f"{axis.name}.{value}"
            case AxisKind.VARIABLE:
                yield f"{axis.name} = {value}"
            case AxisKind.PHASE:
                if index:
                    yield f"{plant.robot.display_names[axis.name]}.busy"
