"""The check for robots that go on with their last command when the node ends."""

from __future__ import annotations

from robosc.expr import tree, types
from robosc.language.events import Kind
from robosc.model import diagnostics, entities


def check_stop(robot: entities.Robot, report: diagnostics.Report) -> None:
    """Warn of a message that carries numbers, in a model that names no stop.

    Nothing is told of a topic of which a message says ``stop: none``, nor where ``stop with
    nothing`` says that the robot may go on.
    """
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
