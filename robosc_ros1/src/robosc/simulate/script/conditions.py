"""Conditions in the language's own syntax, over the state of a whole robot."""

from __future__ import annotations

from robosc.errors import Diagnostic, Severity
from robosc.expr.tree import Expr
from robosc.model.diagnostics import Report
from robosc.model.entities import Robot
from robosc.simulate.faults import InvalidLine
from robosc.source import Source
from robosc.syntax import nodes, parser

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
