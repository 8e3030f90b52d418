"""How events and traces read in messages."""

from __future__ import annotations

from collections.abc import Sequence

from robosc.ir.automaton import Event
from robosc.model.entities import EventKind
from robosc.model.types import Value
from robosc.supervisor import Step

__all__ = ["event_text", "listing", "path_text", "step_text", "trace_text"]


def path_text(path: tuple[str | int, ...]) -> str:
    """``position.x``, ``items[0].kind``."""
    text = ""
    for part in path:
        text += f"[{part}]" if isinstance(part, int) else f".{part}" if text else part
    return text


def event_text(event: Event) -> str:
    """``grab.request``; a tau by its number."""
    if event.kind is EventKind.TAU:
        return f"transition {event.index} of {event.name}"
    return f"{event.name}.{event.kind.value}"


def step_text(step: Step) -> str:
    """``distance.response(free)``, ``Motor: idle->busy``."""
    event = step.event
    if event.kind is EventKind.TAU:
        return f"{event.name}: {step.values[0]}" if step.values else event_text(event)
    shown = []
    for parameter, value in zip(event.parameters, step.values, strict=True):
        name = path_text(parameter.path)
        shown.append(f"{name}: {_value(value)}" if name else _value(value))
    return event_text(event) + (f"({', '.join(shown)})" if shown else "")


def _value(value: Value | None) -> str:
    match value:
        case None:
            return "missing"
        case bool():
            return "true" if value else "false"
    return str(value)


def trace_text(trace: Sequence[Step]) -> str:
    return ", ".join(step_text(step) for step in trace)


def listing(names: Sequence[str], last: str = "and") -> str:
    """``a, b and c``."""
    if len(names) < 2:
        return "".join(names)
    return f"{', '.join(names[:-1])} {last} {names[-1]}"
