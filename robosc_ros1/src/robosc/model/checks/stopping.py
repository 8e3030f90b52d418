"""The check for robots that go on with their last command when the node ends."""

from __future__ import annotations

from collections.abc import Iterable, Mapping

from robosc.errors import Note, listing
from robosc.expr import tree, types
from robosc.language.events import EventKind, Kind
from robosc.model import diagnostics, entities
from robosc.model.checks.used_fields import Usage
from robosc.model.diagnostics import Report
from robosc.model.entities import Command, Communication, Component, Robot
from robosc.model.ros.sent import SentData
from robosc.runtime.core.places import DUE

# The check for models that take the cancel of an action for its end.


_ENDS = (EventKind.RESPONSE, EventKind.ERROR)


def check_cancels(
    components: Iterable[Component], communications: Mapping[str, Communication], report: Report
) -> None:
    """Report transitions for a cancel that lead where the end of the action leads.

    The component then looks as if the goal had ended, while the server still carries it out.
    """
    for component in components:
        transitions = list(component.transitions)
        ends = {(t.communication, t.goto): t for t in transitions if t.event in _ENDS}
        for transition in transitions:
            if transition.event is not EventKind.CANCEL or transition.goto is None:
                continue
            end = ends.get((transition.communication, transition.goto))
            if end is not None:
                name = communications[transition.communication].name
                report.add(
                    "cancel-is-not-end",
                    transition.span,
                    f"{component.name} is in '{transition.goto}', as after the end of {name},"
                    f" while {name} is still being cancelled",
                    f"react to its end: on cancelled from {name} goto {transition.goto}",
                    [Note("this is where it goes at the end", end.span)],
                )


def check_stop(robot: entities.Robot, report: diagnostics.Report) -> None:
    """Warn of a message that carries numbers, in a model that names no stop.

    Nothing is told of a topic of which a message says ``stop: none``, nor where ``stop with
    nothing`` says that the robot may go on.
    """
    if robot.stop is not None and not robot.supervises:
        _check_restricted(robot, robot.commands[robot.stop].communication, report)
    if robot.stop is not None or robot.goes_on:
        return
    unmoved = {c.ros_name for c in robot.communications.values() if c.stop is not None}
    for provide in robot.provides:
        message = robot.commands[provide.communication].communication
        if message.ros_name in unmoved:
            continue
        numbers = [
            expr
            for expr in entities.data_expressions(provide.data)
            if isinstance(expr.type, types.IntegerType | types.DoubleType)
            and not (isinstance(expr, tree.Literal) and not expr.value)
        ]
        if message.kind is Kind.INCOMING and numbers:
            here = provide.span.source is robot.span.source
            report.add(
                "no-stop",
                provide.span if here else robot.component(message.component).span,
                f"when the node ends, the robot goes on with the last {message.name}",
                "name the message that stops it: stop with NAME, or stop with nothing",
            )
            return


def _check_restricted(robot: entities.Robot, stop: Communication, report: Report) -> None:
    """Warn of requirements that forbid the message that stops the robot together with others.

    Where one of them fails, the robot goes on with the last of the others.
    """
    moving = {
        c.key: c.name
        for c in robot.communications.values()
        if c.kind is Kind.INCOMING and c.stop is None and c is not stop
    }
    for requirement in robot.requirements:
        others = [moving[key] for key in requirement.communications if key in moving]
        if others and stop.key in requirement.communications and not requirement.on_data:
            report.add(
                "stop-restricted",
                requirement.span,
                f"{stop.name}, which stops the robot, is forbidden together with"
                f" {listing(others)}: the robot goes on with what was sent last",
                f"leave it out (all except {stop.name}), or give it a requirement of its own",
            )


# The check for answers that say that it did not work, which nothing reads.


_SAYS = "success"
"""The boolean of a response that says by the custom of ROS whether it worked."""


def check_answers(robot: Robot, usage: Usage, report: Report) -> None:
    """Warn of calls whose refusal leads where success leads, though an error leads elsewhere."""
    for call in robot.communications.values():
        if (
            call.kind in (Kind.SERVICE, Kind.ACTION)
            and isinstance(call.response, types.ObjectType)
            and isinstance(call.response.property(_SAYS), types.BooleanType)
            and not usage.uses(call.key, "response", (_SAYS,))
            and any(_depends(component, call.key) for component in robot.components)
        ):
            report.add(
                "refusal-unread",
                call.span,
                f"an answer of {call.name} that says success: false counts as done",
                f"add 'expect: value.{_SAYS},', which makes it an error",
            )


def _depends(component: Component, key: str) -> bool:
    """Whether a component goes elsewhere after an error than after a response."""
    done, failed = (
        _effects(component, key, kind) for kind in (EventKind.RESPONSE, EventKind.ERROR)
    )
    return bool(done) and bool(failed) and done != failed


def _effects(
    component: Component, key: str, kind: EventKind
) -> set[tuple[str | None, tuple[tuple[str, tree.Expr], ...]]]:
    return {
        (taken.goto, tuple((a.variable, a.value) for a in taken.assignments))
        for taken in component.transitions
        if taken.communication == key and taken.event is kind
    }


# Checks of the services and actions that the controller serves.


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
    reacting = [t for _, t in robot.transitions]
    taken = {t.communication for t in reacting if t.event is EventKind.CALL}
    ends = (EventKind.ANSWER, EventKind.REFUSAL)
    answered = {t.communication for t in reacting if t.event in ends}
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
