"""The data of commands: ``requirement move needs value.linear.x <= limit``.

In a controller the state determines the data of a command: they are those of the first provide
statement that holds, and the defaults of the message where it gives none. So what reads ``value``
becomes an expression over the state, as an assignment makes one of a condition on its variable
(Dijkstra's weakest precondition): a requirement, and a transition for each provide statement that
may hold. In a supervisor, the data are those of another controller; there ``value`` remains.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import replace
from typing import Any, TypeAlias

from robosc.expr import evaluation, quantified, traversal, tree, types
from robosc.expr.undefined_data import condition_on_data, known_condition
from robosc.language.events import command_key
from robosc.model import automata, entities
from robosc.model.diagnostics import Report
from robosc.model.ros.interfaces import Field
from robosc.model.typing.compatibility import completed
from robosc.runtime.core.values import NOW

_BOOLEAN = types.BooleanType()
_NOTHING = entities.DataObject(())

Path: TypeAlias = tuple[str | int, ...]
FieldOf: TypeAlias = Callable[[entities.Command, Path], Field | None]
"""Finds the field of a command's data at a path; None if no definition is installed."""


def with_command_data(
    robot: entities.Robot, report: Report, field_of: FieldOf, supervises: bool
) -> entities.Robot:
    """The robot without ``value`` of commands, or, for a supervisor, with it in conditions that
    are never undefined."""
    if report.has_errors:
        return replace(robot, requirements=tuple(r for r in robot.requirements if not r.on_data))
    if supervises or robot.corrected:
        requirements = tuple(map(_judged, robot.requirements))
        return replace(robot, requirements=requirements, supervises=True)
    data: dict[str, _CommandData] = {}

    def of(key: str) -> _CommandData:
        return data.setdefault(key, _CommandData(robot, key, report, field_of))

    requirements = tuple(
        of(r.communications[0]).met(r) if r.on_data else r for r in robot.requirements
    )
    components = tuple(_component(component, of) for component in robot.components)
    return replace(robot, components=components, requirements=requirements)


def _judged(requirement: entities.Requirement) -> entities.Requirement:
    """The requirement, met only where it is defined."""
    return _met_where(requirement, known_condition) if requirement.on_data else requirement


def _met_where(
    requirement: entities.Requirement, condition: Callable[[tree.Expr], tree.Expr]
) -> entities.Requirement:
    met = requirement.condition
    kept = condition(quantified.opposite(met) if requirement.forbids else met)
    return replace(requirement, kind="needs", condition=kept)


def _component(
    component: entities.Component, of: Callable[[str], _CommandData]
) -> entities.Component:
    def given(
        _: str | None, transitions: Iterable[automata.Transition]
    ) -> tuple[automata.Transition, ...]:
        found: list[automata.Transition] = []
        for transition in transitions:
            reads = transition.event.sent and any(
                map(traversal.reads_value, transition.expressions)
            )
            key = command_key(transition.communication, transition.event)
            found += of(key).cases_of(transition) if reads else [transition]
        return tuple(found)

    new = component.behaviour.changed(given)
    return component if new == component.behaviour else replace(component, behaviour=new)


class _CommandData:
    """The data of one command of a controller, as expressions over the state."""

    def __init__(self, robot: entities.Robot, key: str, report: Report, field_of: FieldOf) -> None:
        self._command = robot.commands[key]
        self._name = robot.display_names[key]
        self._report = report
        self._field_of = field_of
        provides = [p for p in robot.provides if p.communication == key]
        last = next((n for n, p in enumerate(provides) if p.condition is None), None)
        given = provides if last is None else provides[: last + 1]
        cases = [(p.condition or tree.TRUE, p.data) for p in given]
        self._cases: Sequence[tuple[tree.Expr, entities.Data]] = (
            [*cases, (tree.TRUE, _NOTHING)] if last is None else cases
        )

    def met(self, requirement: entities.Requirement) -> entities.Requirement:
        """The requirement as a condition on the state."""

        def over_state(condition: tree.Expr) -> tree.Expr:
            met: tree.Expr = tree.TRUE
            for where, data in reversed(self._cases):
                case = condition_on_data(self._substituted(condition, data))
                if case == met:
                    continue
                here = _joined("and", where, case)
                met = _joined("or", here, _joined("and", quantified.opposite(where), met))
            return met

        return _met_where(requirement, over_state)

    def cases_of(self, transition: automata.Transition) -> Iterator[automata.Transition]:
        """A transition for each provide statement that may hold."""
        before: tree.Expr = tree.TRUE
        for where, data in self._cases:
            guard = _joined("and", before, where)
            if transition.guard is not None:
                guard = _joined("and", guard, self._substituted(transition.guard, data))
            assignments = tuple(
                automata.Assignment(a.variable, self._substituted(a.value, data), span=a.span)
                for a in transition.assignments
            )
            known = None if guard == tree.TRUE else condition_on_data(guard)
            yield replace(transition, guard=known, assignments=assignments)
            before = _joined("and", before, quantified.opposite(where))

    def _substituted(self, expr: tree.Expr, data: entities.Data) -> tree.Expr:
        def given(leaf: tree.Literal | tree.Leaf) -> tree.Expr:
            return self._at(data, leaf) if isinstance(leaf, tree.ValueRef) else leaf

        return traversal.fold(expr, given, _folded)

    def _at(self, data: entities.Data, reference: tree.ValueRef) -> tree.Expr:
        """What provided data have at the path of a reference to ``value``."""
        path = reference.path
        while isinstance(data, entities.DataObject | entities.DataArray):
            if not path and data != _NOTHING:
                return self._unknown(reference, "it is given part by part")
            inner = _inside(data, path[0]) if path else None
            if inner is None:
                return self._left_out(reference, data, path)
            data, path = inner, path[1:]
        if isinstance(data, tree.Literal) and data.value is NOW:
            return self._unknown(reference, "it gets the time at which it is sent")
        return traversal.part_of(data, path, reference.type, data.span) if path else data

    def _left_out(
        self,
        reference: tree.ValueRef,
        data: entities.DataObject | entities.DataArray,
        path: Sequence[str | int],
    ) -> tree.Expr:
        """The default of a field that no provide statement gives; ``path`` leads there from the
        data."""
        if isinstance(data, entities.DataArray):
            return self._unknown(reference, "the provide statement lists the elements of an array")
        field = self._field_of(self._command, reference.path)
        if field is None and not self._command.communication.binding.found:
            return self._unknown(reference, "its definition, with its default, is not installed")
        for place, step in enumerate(path, len(reference.path) - len(path)):
            if isinstance(step, int):
                whole = self._field_of(self._command, reference.path[:place])
                if whole is not None and not -whole.elements <= step < whole.elements:
                    return self._unknown(
                        reference, "an array that is not given has no such element"
                    )
        value: Any = None if field is None else field.default
        if value is None:
            value = completed(None, reference.type)
            if field is not None and isinstance(reference.type, types.ArrayType):
                value = (completed(None, reference.type.element),) * field.elements
        return tree.Literal(value, reference.type, reference.span)

    def _unknown(self, reference: tree.ValueRef, reason: str) -> tree.Expr:
        what = traversal.path_text(("value", *reference.path))
        self._report.add(
            "data-not-given",
            reference.span or self._command.communication.span,
            f"{what} of {self._name} is not known: {reason}",
            f"give it in each provide statement of {self._name}, or read the parts that are given",
        )
        return reference


def _inside(
    data: entities.DataObject | entities.DataArray, step: str | int
) -> entities.Data | None:
    if isinstance(data, entities.DataObject):
        return dict(data.fields).get(str(step))
    here = isinstance(step, int) and step < len(data.elements)
    return data.elements[int(step)] if here else None


def _folded(node: tree.Operation, operands: tuple[tree.Expr, ...]) -> tree.Expr:
    """The operation on what stands for ``value``; what has constants only is evaluated here."""
    whole = traversal.with_operands(node, operands)
    match whole:
        case tree.Binary(operator="and" | "or", left=left, right=right):
            return _joined(whole.operator, left, right)
        case tree.Binary(operator="=>", left=tree.Literal() as left, right=right):
            return _joined("or", quantified.opposite(left), right)
    constant = all(isinstance(operand, tree.Literal) for operand in operands)
    if (
        not constant
        or traversal.may_be_undefined(whole)
        or any(True for _ in traversal.parameters_of(whole))
    ):
        return whole
    return tree.Literal(evaluation.evaluate(whole, _no_leaf), whole.type, node.span)


def _no_leaf(leaf: tree.Leaf) -> types.Value | None:
    raise AssertionError(f"{leaf} is not a constant")


def _joined(operator: str, left: tree.Expr, right: tree.Expr) -> tree.Expr:
    """``and`` or ``or`` of two conditions, without constants."""
    decides = operator == "or"
    for one, other in ((left, right), (right, left)):
        if isinstance(one, tree.Literal):
            return one if one.value is decides else other
    return tree.Binary(operator, left, right, _BOOLEAN)
