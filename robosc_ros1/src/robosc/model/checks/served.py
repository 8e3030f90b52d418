"""Checks of the services and actions that the controller serves."""

from __future__ import annotations

from robosc.errors import Note
from robosc.expr import tree, types
from robosc.language.events import EventKind, Kind
from robosc.model.diagnostics import Report
from robosc.model.entities import Command, Communication, Robot
from robosc.model.ros.sent import SentData
from robosc.runtime.core.places import DUE


def check_served(robot: Robot, sent: SentData, report: Report) -> None:
    """Report names that are served twice, or served and called, calls that nobody takes, goals that
    nobody answers, and refusals of which a caller in ROS 2 cannot know."""
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
    if sent.is_for_ros2:
        for call in served:
            _check_refusals(call, robot, sent, report)


def _check_refusals(call: Communication, robot: Robot, sent: SentData, report: Report) -> None:
    """Report a service whose refused calls get the response that others may get, too.

    ROS 2 has no errors of services.
    """
    error = Command(call, EventKind.REFUSAL)
    if call.kind is not Kind.SERVED_SERVICE or not call.binding.found:
        return
    success = sent.field_of(error, ("success",))
    if success is not None and success.type.base == "bool":
        return
    # What a state performs is given in that state alone, and a call may be refused in all others.
    due = {f"{where}.{path} {DUE}" for where, path in robot.performed.get(error.key, ())}
    for provide in robot.provides:
        where = provide.condition
        performed = isinstance(where, tree.StateRef) and f"{where.component}.{where.state}" in due
        if provide.communication == error.key and not performed:
            return
    hint = "take a type whose response has the fields bool success and string message"
    if not isinstance(error.type, types.NoneType):
        hint += f", or say what a refused call gets: provide {call.name}.error with {{ … }}"
    report.add(
        "refusal-not-seen",
        call.span,
        f"in ROS 2 a refused call of '{call.name}' gets a response with default values, as if it"
        f" were done: {call.binding.type} has no field 'success'",
        hint,
    )


def _report_twice(second: Communication, first: Communication, what: str, report: Report) -> None:
    report.add(
        "served-twice",
        second.span,
        f"the {second.kind.value} '{second.identifier}' {what}",
        "give one of them another 'identifier:'",
        [Note("it is here", first.span)],
    )
