"""The constants that a model compares numbers with, for the plots of viewers."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping

from robosc.expr import traversal, tree, types
from robosc.model.automata import Behaviour
from robosc.model.entities import Robot


def thresholds(robot: Robot) -> Mapping[str, list[float]]:
    """Sorted, by the name of what is compared.

    That is a variable, ``Component.variable``, or a number that an event brings: the event's name
    and the names on the way to the number, ``scan.response front``.
    """
    found: dict[str, set[float]] = {}
    for name, constant in _comparisons(robot):
        found.setdefault(name, set()).add(constant)
    return {name: sorted(constants) for name, constants in sorted(found.items())}


def _comparisons(robot: Robot) -> Iterator[tuple[str, float]]:
    for requirement in robot.requirements:
        yield from _compared(requirement.condition, "")
    for provide in robot.provides:
        yield from _compared(provide.condition, "")
    for communication in robot.communications.values():
        name = robot.display_names[communication.key]
        yield from _converted(communication.response, f"{name}.response")
        yield from _compared(communication.expect, f"{name}.response")
        yield from _converted(communication.feedback, f"{name}.feedback")
    for component in robot.components:
        yield from _in_behaviour(component.behaviour, robot)


def _in_behaviour(behaviour: Behaviour, robot: Robot) -> Iterator[tuple[str, float]]:
    for transition in behaviour.all_transitions:
        name = robot.display_names.get(transition.communication, "")
        event = f"{name}.{transition.event.value}"
        yield from _compared(transition.guard, event)
        for assignment in transition.assignments:
            yield from _compared(assignment.value, event)


def _compared(expr: tree.Expr | None, event: str) -> Iterator[tuple[str, float]]:
    """What an expression compares with numbers; ``value`` in it is what ``event`` brings."""
    for node in traversal.walk(expr) if expr is not None else ():
        match node:
            case tree.Binary(left=left, right=right) if node.operation.is_comparison:
                for one, other in ((left, right), (right, left)):
                    name = _name(one, event)
                    if name and isinstance(other, tree.Literal) and _is_number(other.value):
                        yield name, float(other.value)
            case tree.Convert(argument=argument, type=enum) if name := _name(argument, event):
                yield from _rules(enum, name)


def _name(expr: tree.Expr, event: str) -> str:
    """What viewers call a number; empty if they have no plot of it."""
    match expr:
        case tree.VariableRef(component=component, variable=variable):
            return f"{component}.{variable}"
        case tree.ValueRef(path=path) if all(isinstance(part, str) for part in path):
            return " ".join((event, *map(str, path)))
    return ""


def _is_number(value: object) -> bool:
    return type(value) in (int, float) and math.isfinite(value)  # type: ignore[arg-type]


def _converted(type_: types.Type, name: str) -> Iterator[tuple[str, float]]:
    """What the rules of enums compare, wherever in a message they are."""
    match type_:
        case types.EnumType():
            yield from _rules(type_, name)
        case types.ObjectType(properties=properties):
            for part, inner in properties:
                yield from _converted(inner, f"{name} {part}")


def _rules(enum: types.EnumType, name: str) -> Iterator[tuple[str, float]]:
    for rule in enum.rules:
        yield from _compared(tree.condition_of(rule), name)
    yield from _converted(enum.source, name)
