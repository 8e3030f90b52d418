"""Which fields of real definitions a model reads or sends: its tests need fill no others."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from dataclasses import replace

from robosc.model.entities import Data, DataArray, DataObject, ResultTransition, Robot
from robosc.model.expr import Expr, walk
from robosc.model.ros.types import is_ros_type
from robosc.model.types import ArrayType, EnumType, ObjectType, Type

__all__ = ["used_fields", "with_fields"]


def with_fields(type_: Type, names: frozenset[str]) -> Type:
    """The type without those fields of ROS messages that have none of the names."""
    if isinstance(type_, ArrayType):
        return ArrayType(with_fields(type_.element, names))
    if not isinstance(type_, ObjectType):
        return type_
    properties = type_.properties
    if is_ros_type(type_):
        properties = tuple((name, inner) for name, inner in properties if name in names)
    kept = tuple((name, with_fields(inner, names)) for name, inner in properties)
    return replace(type_, properties=kept)


def used_fields(robot: Robot) -> frozenset[str]:
    """The names of all fields that the model reads or sends somewhere."""
    read = (
        step
        for expr in _reading(robot)
        for part in walk(expr)
        for step in getattr(part, "path", ())
        if isinstance(step, str)
    )
    return frozenset((*read, *(name for p in robot.provides for name in _sent(p.data))))


def _sent(data: Data) -> Iterator[str]:
    if isinstance(data, DataObject):
        for name, inner in data.fields:
            yield name
            yield from _sent(inner)
    elif isinstance(data, DataArray):
        for inner in data.elements:
            yield from _sent(inner)


def _reading(robot: Robot) -> Iterator[Expr]:
    """The expressions that may read what comes in."""
    types: list[Type] = [
        type_ for c in robot.communications.values() for type_ in (c.response, c.feedback)
    ]
    for component in robot.components:
        behaviour = component.behaviour
        if behaviour is None:
            continue
        types += [variable.type for variable in behaviour.variables]
        yield from _of_transitions(behaviour.transitions)
        for state in behaviour.states:
            yield from _of_transitions(state.transitions)
    for enum in _enums(types):
        yield from (rule.condition for rule in enum.rules)


def _of_transitions(transitions: Iterable[ResultTransition]) -> Iterator[Expr]:
    for transition in transitions:
        yield from () if transition.guard is None else (transition.guard,)
        yield from (assignment.value for assignment in transition.assignments)


def _enums(types: list[Type]) -> Iterator[EnumType]:
    while types:
        match types.pop():
            case EnumType() as enum:
                yield enum
                types.append(enum.source)
            case ArrayType(element=element):
                types.append(element)
            case ObjectType(properties=properties) as object_ if not is_ros_type(object_):
                types += [inner for _, inner in properties]
