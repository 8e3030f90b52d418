"""Texts of events, traces and counts in messages."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from math import log10
from textwrap import shorten
from typing import Any

from robosc.errors import listing
from robosc.expr.traversal import path_text
from robosc.expr.tree import REASON
from robosc.expr.types import Value
from robosc.plant.automaton import Event, EventParameter
from robosc.plant.data.classes import Classes
from robosc.supervisor import Step

_LONG = 120
"""Characters of a requirement that a message quotes."""


def event_text(event: Event) -> str:
    """Return ``grab.request``; for a transition of a component ``Motor: idle->busy``; for a request
    with known data ``move.request(value > 0.5)``."""
    if event.kind.of_component:
        return f"{event.name}: {event.path}"
    data = [part_text(event.parameters[i], event.parameters[i].values[0]) for i in event.known]
    return _name(event) + (f"({', '.join(data)})" if data else "")


def _name(event: Event) -> str:
    return f"{event.name}.{event.kind.word}"


def step_text(step: Step) -> str:
    """Return ``distance.response(free)``, for a tau ``Motor: idle->busy``."""
    event = step.event
    if event.kind.of_component:
        return f"{event.name}: {step.values[0]}" if step.values else event_text(event)
    shown = map(part_text, event.parameters, step.values)
    return _name(event) + (f"({', '.join(shown)})" if step.values else "")


def part_text(parameter: EventParameter, value: Value | None) -> str:
    """Return ``free``, ``x: 3`` or ``value > 0.2``: a parameter's value, or its class."""
    if parameter.labels is not None:
        return str(parameter.shown(value))
    name = "reason" if parameter.path == REASON else path_text(parameter.path)
    return f"{name}: {_value(value)}" if name else _value(value)


def short_step_text(step: Step) -> str:
    """Return the same with ranges of numbers as people write them: ``battery.response(charge 0.3 …
    0.9)``."""
    shown = map(_short_part, step.event.parameters, step.values)
    return _name(step.event) + (f"({', '.join(shown)})" if step.values else "")


def _short_part(parameter: EventParameter, value: Value | None) -> str:
    classes, found = parameter.values, ""
    if parameter.labels is not None and not parameter.renews and isinstance(classes, Classes):
        found = _range(classes, value)
    if found:
        return f"{path_text(parameter.path)} {found}".strip()
    return part_text(parameter, value)


_OPPOSITE = {"<": ">=", "<=": ">", ">": "<=", ">=": "<"}


def _range(classes: Classes, value: Value | None) -> str:
    """Return the class of a number as people write it, ``0.3 … 0.9`` or ``< 0.3``; empty where it
    is no such range.

    It does not say whether the ends and NaN are in it: the condition does.
    """
    if not isinstance(value, float | int):
        return ""
    if value != value:
        return "not a number"
    number = classes.index(value)
    condition = classes.condition([number], [number])
    bounds = [bound for part in condition.alternatives for bound in part]
    if any(operator not in _OPPOSITE for operator, _ in bounds):
        return ""
    if condition.negated:
        bounds = [(_OPPOSITE[operator], constant) for operator, constant in bounds]
    if len(bounds) == 1:
        return " ".join(map(str, bounds[0]))
    low: list[Any] = [constant for operator, constant in bounds if operator in (">", ">=")]
    high: list[Any] = [constant for operator, constant in bounds if operator in ("<", "<=")]
    is_range = len(low) == len(high) == 1 and low[0] < high[0]
    return f"{low[0]} … {high[0]}" if is_range else ""


def _value(value: Value | None) -> str:
    match value:
        case None:
            return "missing"
        case bool():
            return "true" if value else "false"
    return str(value)


def trace_text(trace: Sequence[Step]) -> str:
    """Return the steps of a trace, separated by commas."""
    return ", ".join(step_text(step) for step in trace)


def quoted(text: str) -> str:
    """Return a requirement in quotes, a long one shortened: the message has its place."""
    return f"'{shorten(text, _LONG, placeholder=' …')}'"


def amount(number: int) -> str:
    """Return a count; a very large one as a power of ten."""
    return str(number) if number < 10**12 else f"about 10^{int(log10(number))}"


def contributors(sizes: Iterable[tuple[str, int]]) -> str:
    """Return the four largest sizes, each with the names that have it."""
    by_size: dict[int, list[str]] = {}
    for name, size in sizes:
        by_size.setdefault(size, []).append(name)
    groups = []
    for size in sorted(by_size, reverse=True)[:4]:
        names = by_size[size]
        others = [f"{len(names) - 2} others"] if len(names) > 3 else names[2:]
        each = " each" if len(names) > 1 else ""
        groups.append(f"{listing([*names[:2], *others])} ({size} values{each})")
    return ", ".join(groups)
