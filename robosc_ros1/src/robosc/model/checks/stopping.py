"""The check for robots that go on with their last command when the node ends."""

from __future__ import annotations

from collections.abc import Iterable, Mapping

from robosc.errors import Note, listing
from robosc.expr import tree, types
from robosc.language.events import EventKind, Kind
from robosc.model import diagnostics, entities
from robosc.model.diagnostics import Report
from robosc.model.entities import Communication, Component

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
