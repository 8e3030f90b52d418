"""Checks of the services and actions that the controller serves."""

from __future__ import annotations

from robosc.errors import Note
from robosc.language.events import EventKind, Kind
from robosc.model.diagnostics import Report
from robosc.model.entities import Communication, Robot


def check_served(robot: Robot, report: Report) -> None:
    """Report names that are served twice, or served and called, and calls that nobody takes, or
    goals that nobody answers."""
    served = [c for c in robot.communications.values() if c.sort.served]
    by_name: dict[str, Communication] = {}
    for call in served:
        first = by_name.setdefault(call.ros_name, call)
        if first is not call:
            _report_twice(call, first, "is served already", report)
    for called in robot.communications.values():
        if called.kind.value in ("service", "action") and called.ros_name in by_name:
            _report_twice(called, by_name[called.ros_name], "is served by this controller", report)
    taken = {
        t.communication for c in robot.components for t in c.transitions
        if t.event is EventKind.CALL
    }  # fmt: skip
    answered = {
        t.communication for c in robot.components for t in c.transitions
        if t.event in (EventKind.ANSWER, EventKind.REFUSAL)
    }  # fmt: skip
    for call in served:
        if call.kind is Kind.SERVED_ACTION and call.key not in answered:
            report.add(
                "unanswered",
                call.span,
                f"no component ever answers '{call.name}': whoever sends a goal waits forever",
                f"add to a state: on response to {call.name} goto STATE",
            )
    for call in served:
        if call.key not in taken:
            report.add(
                "call-not-taken",
                call.span,
                f"every call of '{call.name}' is refused: no component takes its request",
                f"add to a state: on request from {call.name} goto STATE",
            )


def _report_twice(one: Communication, first: Communication, what: str, report: Report) -> None:
    report.add(
        "served-twice",
        one.span,
        f"the {one.kind.value} '{one.identifier}' {what}",
        "give one of them another 'identifier:'",
        [Note("it is here", first.span)],
    )
