"""Requirements on the data of commands: ``requirement move needs value.linear.x <= limit``.

In a controller the state determines the data of a command: they are those of the first provide
statement that holds. So such a requirement becomes a condition on the state, as an assignment
makes one of a condition on its variable (Dijkstra's weakest precondition). It does not hold where
the data are undefined or no provide statement holds.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

from robosc.errors import Note
from robosc.model.diagnostics import Report
from robosc.model.entities import Data, DataArray, DataObject, Provide, Requirement, Robot
from robosc.model.evaluation import evaluate
from robosc.model.expr import (
    FALSE,
    Binary,
    Expr,
    Leaf,
    Literal,
    Operation,
    ValueRef,
    opposite,
)
from robosc.model.presence import condition_on_data
from robosc.model.traversal import fold, part_of, path_text, with_operands
from robosc.model.types import BooleanType
from robosc.runtime.values import NOW
from robosc.source import Span

_BOOLEAN = BooleanType()


def with_command_data(robot: Robot, report: Report) -> Robot:
    """The robot with each requirement as a condition on the state."""
    found: list[Requirement] = []
    sound = not report.has_errors
    for requirement in robot.requirements:
        if not requirement.on_data:
            found.append(requirement)
        elif sound:
            (key,) = requirement.communications
            provides = [p for p in robot.provides if p.communication == key]
            name = robot.display_names[key]
            condition = _Substitution(requirement, name, report).over(provides)
            found.append(replace(requirement, kind="needs", condition=condition))
    return replace(robot, requirements=tuple(found))


class _NotGivenError(Exception):
    """The data do not say what is at a path."""


class _Substitution:
    """Puts the data of one command in the place of ``value`` in one of its requirements."""

    def __init__(self, requirement: Requirement, name: str, report: Report) -> None:
        self._requirement = requirement
        self._name = name
        self._report = report

    def over(self, provides: Sequence[Provide]) -> Expr:
        """The condition on the state that the data meet the requirement."""
        if not provides:
            self._report.add(
                "data-not-given",
                self._requirement.span,
                f"a requirement reads the data of {self._name}, and no provide statement gives any",
                f"add 'provide {self._name} with …'",
            )
        met: Expr = FALSE
        for provide in reversed(provides):
            case = self._met_by(provide)
            if provide.condition is None:
                met = case
            else:
                here = _joined("and", provide.condition, case)
                elsewhere = _joined("and", opposite(provide.condition), met)
                met = _joined("or", here, elsewhere)
        return met

    def _met_by(self, provide: Provide) -> Expr:
        def given(leaf: Literal | Leaf) -> Expr:
            if not isinstance(leaf, ValueRef):
                return leaf
            try:
                return _at(provide.data, leaf)
            except _NotGivenError:
                span = self._requirement.span if leaf.span is None else leaf.span
                self._not_given(path_text(("value", *leaf.path)), span, provide)
                return leaf

        condition = fold(self._requirement.condition, given, _folded)
        return condition_on_data(opposite(condition) if self._requirement.forbids else condition)

    def _not_given(self, what: str, span: Span, provide: Provide) -> None:
        self._report.add(
            "data-not-given",
            span,
            f"a requirement reads {what} of {self._name}, and a provide statement does not give it",
            "give it there, or read the parts that are given",
            [Note("the provide statement is here", provide.span)],
        )


def _at(data: Data, reference: ValueRef) -> Expr:
    """What provided data have at the path of a reference to ``value``."""
    path = reference.path
    while isinstance(data, DataObject | DataArray):
        if not path:
            raise _NotGivenError
        step, path = path[0], path[1:]
        if isinstance(data, DataObject):
            inner = dict(data.fields).get(str(step))
        else:
            here = isinstance(step, int) and step < len(data.elements)
            inner = data.elements[int(step)] if here else None
        if inner is None:
            raise _NotGivenError
        data = inner
    if isinstance(data, Literal) and data.value is NOW:
        raise _NotGivenError
    return part_of(data, path, reference.type, data.span) if path else data


def _folded(node: Operation, operands: tuple[Expr, ...]) -> Expr:
    """The operation on what stands for ``value``; a condition on constants is decided here."""
    whole = with_operands(node, operands)
    match whole:
        case Binary(operator="and" | "or", left=left, right=right):
            return _joined(whole.operator, left, right)
        case Binary(operator="=>", left=Literal() as left, right=right):
            return _joined("or", opposite(left), right)
        case Binary() if whole.operation.is_comparison and all(map(_is_literal, operands)):
            return Literal(evaluate(whole, lambda leaf: None), _BOOLEAN, node.span)
    return whole


def _is_literal(expr: Expr) -> bool:
    return isinstance(expr, Literal)


def _joined(operator: str, left: Expr, right: Expr) -> Expr:
    """``and`` or ``or`` of two conditions, without constants."""
    decides = operator == "or"
    for one, other in ((left, right), (right, left)):
        if isinstance(one, Literal):
            return one if one.value is decides else other
    return Binary(operator, left, right, _BOOLEAN)
