"""What a script expects: true, or a fault that says what is the case instead."""

from __future__ import annotations

import math
import re
from collections.abc import Sequence
from itertools import groupby
from typing import Any

from robosc.errors import Diagnostic, Severity, listing
from robosc.expr import traversal, tree
from robosc.expr.tree import Expr
from robosc.model.diagnostics import Report
from robosc.model.entities import Robot
from robosc.plant import automaton, model_text
from robosc.runtime.core import places, values
from robosc.simulate.faults import Failed, InvalidLine
from robosc.simulate.machines.machine import (
    EVENT_NAME,
    Happening,
    Machine,
    event_and_value,
    find_events,
    is_name,
    label,
    without_cases,
    without_timeouts,
)
from robosc.simulate.values.event_data import complete
from robosc.simulate.values.literals import by_path, literal_text, parse_raw, path_in
from robosc.source import Source
from robosc.syntax import nodes, parser

# Conditions in the language's own syntax, over the state of a whole robot.


_BEFORE = "robot r { requirement always "


def condition(text: str, robot: Robot) -> Expr:
    """The condition that a text means: all that a requirement of the robot's model can say.

    Raises:
        InvalidLine: it is no condition; with the reason.
    """
    report = Report()
    expr = robot.conditions(_parsed(text), report)
    if expr is None:
        raise InvalidLine(_in_words(report.diagnostics[0]))
    return expr


def _parsed(text: str) -> nodes.ExprNode:
    if not text.strip():
        raise InvalidLine("a condition is missing, such as Motor.moving and Sensor.value = free")
    tree, diagnostics = parser.parse(Source("condition", _BEFORE + text + "\n}"))
    errors = [d for d in diagnostics if d.severity is Severity.ERROR]
    if errors:
        column = max(1, min(errors[0].span.start - len(_BEFORE), len(text)) + 1)
        raise InvalidLine(f"'{text}' is not a condition: {_in_words(errors[0])} at column {column}")
    found = tree.declarations if tree is not None else ()
    if len(found) != 1 or not isinstance(found[0], nodes.RequirementNode):
        raise InvalidLine(f"'{text}' is not a condition")
    return found[0].condition


def _in_words(fault: Diagnostic) -> str:
    return f"{fault.message} ({fault.hint})" if fault.hint else fault.message


_SENT = re.compile(rf"({EVENT_NAME})(?:\s*\*\s*(\d{{1,6}}))?", re.ASCII)


def expect(text: str, machine: Machine, latest: Sequence[Happening]) -> None:
    """Hold the machine, and what happened last, against an expectation.

    Raises:
        Failed: it is not met.
        InvalidLine: it means nothing.
    """
    word, _, rest = text.partition(" ")
    rest = rest.strip()
    if word in ("enabled", "disabled"):
        _enabled(rest, machine, word == "enabled")
    elif word == "sent":
        _sent(rest, machine, latest)
    elif word == "data":
        _data(rest, machine, latest)
    elif text == "applied":
        wrong = [h for h in latest if h.outcome == "mismatch"]
        if wrong or not latest:
            raise Failed(
                f"{wrong[0].name}.{wrong[0].kind}: {wrong[0].detail}"
                if wrong
                else "nothing happened"
            )
    elif word == "blocked":
        _blocked(rest, latest)
    elif text == "mismatch":
        if not any(h.outcome == "mismatch" for h in latest):
            raise Failed("there was no mismatch")
    elif text == "marked":
        if not machine.state.marked(machine.plant.robot):
            raise Failed("the state is not marked")
    elif text == "stopped":
        if machine.stopped is None:
            raise Failed("there was no safe stop")
    else:
        wanted = condition(text, machine.plant.robot)
        # A single event may choose what a test of data comes to, whatever the data are.
        if not machine.state.holds(machine.plant.view.expression(wanted)):
            raise Failed(f"{text} does not hold: {_instead(wanted, machine)}")


def _instead(wanted: tree.Expr, machine: Machine) -> str:
    """What everything is that the condition reads."""
    state = machine.state
    found: dict[str, None] = {}
    for part in traversal.walk(wanted):
        match part:
            case tree.StateRef(component=component):
                found[f"{component} is in {places.place_of(state.components[component])}"] = None
            case tree.VariableRef(component=component, variable=name):
                value = literal_text(state.variables[f"{component}.{name}"])
                found[f"{component}.{name} is {value}"] = None
            case tree.PhaseRef(communication=key):
                name = machine.plant.robot.display_names[key]
                found[f"{name} is {state.phases[key]}"] = None
    return listing(list(found)) or f"it is {model_text.to_dsl(wanted, machine.plant.robot)}"


def _blocked(text: str, latest: Sequence[Happening]) -> None:
    word, _, because = text.partition(" ")
    if text and (word != "because" or not because):
        raise InvalidLine("write: expect blocked; or: expect blocked because REASON; REASON")
    found = [h.judged for h in latest if h.outcome == "blocked"]
    if not found:
        raise Failed("nothing was blocked")
    told = "; ".join(reason["text"] for reason in (found[-1] or {})["blocked_by"])
    if because and told != because:
        raise Failed(f"it was blocked because {told}")


def _enabled(text: str, machine: Machine, wanted: bool) -> None:
    text, _, because = text.partition(" because ")
    written = event_and_value(text)
    if written is None:
        raise InvalidLine("write an event: expect enabled grab.request")
    event = _any_event(written[0], machine)
    raw = parse_raw(written[1])
    whole = event.whole or event
    cases = [c for c in machine.commands() if (c.event.whole or c.event) == whole]
    if cases and raw is None:
        # Of what another controller sends, some data must be allowed.
        enabled = any(case.enabled for case in cases)
        if enabled is not wanted:
            reasons = dict.fromkeys(str(reason) for case in cases for reason in case.reasons)
            why = "enabled" if enabled else f"not: {'; '.join(reasons)}"
            raise Failed(f"{label(event)} is {why}")
        texts = dict.fromkeys(reason.text for case in cases for reason in case.reasons)
        told = "; ".join(texts)
        if because and told != because:
            raise Failed(f"{label(event)} is disabled because {told}")
        return
    if because:
        raise InvalidLine(f"{label(event)} is no command: only commands have reasons")
    given = None
    if raw is not None:
        given = complete(machine.plant.robot, event, raw, label(event))
    if machine.can(event, given) is not wanted:
        raise Failed(f"{text} {'cannot' if wanted else 'can'} happen now")


def _any_event(text: str, machine: Machine) -> automaton.Event:
    """One event by name, in whatever machine: a bare name is the request, or the only event."""
    plain = text.replace("^", "")
    named = [e for e in machine.plant.events if is_name(e, plain)] or find_events(machine, text)
    named = without_timeouts(without_cases(named))
    if len(named) > 1:
        requests = [e for e in named if e.kind.sent]
        if len(requests) != 1:
            raise InvalidLine(f"'{text}' can mean {listing([label(e) for e in named], 'or')}")
        named = requests
    return named[0]


def _sent(text: str, machine: Machine, latest: Sequence[Happening]) -> None:
    wanted: list[str] = []
    if text != "nothing":
        for item in text.split(","):
            match = _SENT.fullmatch(item.strip())
            if match is None:
                raise InvalidLine("write commands in order: expect sent stop, move * 3; or nothing")
            event = _any_event(match[1], machine)
            if not event.controllable:
                raise InvalidLine(f"{label(event)} is not sent by a controller")
            wanted += [label(event)] * int(match[2] or 1)
    sent = [f"{h.name}.{h.kind}" for h in latest if h.is_command and h.outcome == "applied"]
    if sent != wanted:
        raise Failed(f"sent: {_folded(sent)}; expected: {_folded(wanted)}")


def _folded(names: Sequence[str]) -> str:
    """``stop.request, move.request * 3``."""
    runs = [(name, len(list(same))) for name, same in groupby(names)]
    return ", ".join(f"{n} * {c}" if c > 1 else n for n, c in runs) or "nothing"


def _data(text: str, machine: Machine, latest: Sequence[Happening]) -> None:
    name, _, rest = text.partition(" ")
    event = _any_event(name, machine)
    wanted = parse_raw(rest)
    sent = [h for h in latest if h.name == event.name and h.kind == event.kind.word]
    if wanted is None:
        raise InvalidLine("write what is sent: expect data move linear.x: 0.4")
    if not sent:
        raise Failed(f"{label(event)} was not sent")
    data: Any = values.jsonable(sent[-1].value)
    if not isinstance(data, dict):
        data = {} if data is None else {"": data}
    names = list(by_path(data))
    if not isinstance(wanted, dict):
        if len(names) != 1:
            raise InvalidLine(f"write which part: {', '.join(names) or 'it has none'}")
        wanted = {names[0]: wanted}
    for path, value in wanted.items():
        found = data
        try:
            # What another controller sent has its parts by path.
            for step in (path,) if path in data else path_in(path) or (path,):
                found = found[step]
        except (LookupError, TypeError):
            there = ", ".join(names) or "defaults alone"
            raise Failed(f"{path} was not sent; sent were {there}") from None
        if not _same(found, values.jsonable(value)):
            raise Failed(f"{path} was {literal_text(found)}, not {literal_text(value)}")


def _same(left: Any, right: Any) -> bool:
    """Whether a part that was sent is what was written: other fields of objects may differ."""
    match left, right:
        case list(), list():
            return len(left) == len(right) and all(map(_same, left, right))
        case dict(), dict():
            return all(name in left and _same(left[name], part) for name, part in right.items())
        case int() | float(), int() | float() if bool not in (type(left), type(right)):
            return math.isclose(left, right, rel_tol=1e-9, abs_tol=1e-12)
    return type(left) is type(right) and bool(left == right)
