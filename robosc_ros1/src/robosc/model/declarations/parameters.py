"""Parameters of the generated node that a model declares: names in ROS, other defaults."""

from __future__ import annotations

import json
from collections.abc import Mapping
from dataclasses import fields, is_dataclass, replace
from typing import Any, TypeVar

from robosc.errors import Note, listing
from robosc.expr import tree, types
from robosc.model import diagnostics, entities
from robosc.model.typing.compatibility import completed
from robosc.runtime.core import model, settings
from robosc.runtime.core.persistence import is_one_of
from robosc.source import Span
from robosc.syntax.nodes import ExprNode

_Node = TypeVar("_Node", entities.Robot, tree.Expr)

_GROUPS = ("goal_timeout", "qos", "qos_overrides", "rate", "timeout")
"""Namespaces of parameters that every generated node has, or may have."""
_OF_ROS = ("start_type_description_service", "use_sim_time")
"""Parameters that ROS itself declares for every node."""
KEEPING = (
    model.Parameter(
        "persistent_file",
        "string",
        "",
        "file of the values of persistent variables (empty: one named after the node)",
        attribute="persistent_file",
    ),
    model.Parameter(
        "forget",
        "boolean",
        False,
        "persistent variables begin anew, whatever their file has",
        attribute="forget",
    ),
)
"""The parameters of nodes with persistent variables."""


def check_parameters(robot: entities.Robot, report: diagnostics.Report) -> None:
    """Report names that clash with parameters of every node, or with others of the model."""
    taken = {parameter.name for parameter in settings.declared(())}.union(_GROUPS, _OF_ROS)
    if robot.persistent:
        taken.update(parameter.name for parameter in KEEPING)
    seen: dict[str, tree.RosParameter] = {}
    for parameter in robot.parameters:
        name = parameter.name
        group = name.partition("/")[0]
        if group in taken:
            what = f"the parameter ~{name}" if name == group else f"parameters ~{group}/…"
            report.add(
                "parameter-name",
                parameter.span,
                f"every controller has {what} of its own",
                "give it another name",
            )
            continue
        first = seen.get(name) or seen.get(group)
        if first is not None and first is not parameter:
            report.add(
                "parameter-name",
                parameter.span,
                f"'{parameter.key}' and '{first.key}' would both be the parameter ~{first.name}",
                "give one of them another name",
                [Note("the other one is here", first.span)],
            )
        seen.setdefault(name, parameter)


def with_parameters(robot: entities.Robot, values: Mapping[str, Any]) -> entities.Robot:
    """The robot with other defaults of its parameters, given by their names in ROS.

    The conditions that it reads have them, too. Other names are ignored.
    """
    changed = {p.name: values[p.name] for p in robot.parameters if p.name in values}
    if not changed:
        return robot

    def read(node: ExprNode, report: diagnostics.Report) -> tree.Expr | None:
        found = robot.conditions(node, report)
        return None if found is None else _with_defaults(found, changed)

    return replace(_with_defaults(robot, changed), conditions=read)


def with_starts(robot: entities.Robot, values: Mapping[str, Any]) -> entities.Robot:
    """The robot in which persistent variables start with these values, by name; the component may
    be left out where only one has a variable of that name.

    Raises:
        ValueError: there is no such variable, or the value is not of its type.
    """
    stays = robot.persistent
    chosen: dict[str, Any] = {}
    for name, value in values.items():
        keys = [key for key, v in stays.items() if name in (key, v.name)]
        if len(keys) != 1:
            known = f"; there are {listing(list(stays))}" if stays else ""
            raise ValueError(f"'{name}' is no persistent variable{known}")
        allowed = types.domain(stays[keys[0]].type)
        if allowed is None or not is_one_of(value, allowed):
            told = json.dumps(value, default=repr)
            raise ValueError(f"{keys[0]} cannot start with {told}: it is {stays[keys[0]].type}")
        chosen[keys[0]] = value

    def started(component: entities.Component) -> entities.Component:
        variables = tuple(
            replace(v, initial=chosen.get(v.key, v.initial)) for v in component.variables
        )
        return replace(component, behaviour=replace(component.behaviour, variables=variables))

    return replace(robot, components=tuple(map(started, robot.components))) if chosen else robot


def _of_type(value: Any, type_: types.Type) -> Any:
    """A value of a parameter as the model has it: arrays are tuples, objects have all fields."""
    match type_:
        case types.ArrayType() | types.ObjectType():
            return completed(value, type_)
    return value


def _with_defaults(node: _Node, changed: Mapping[str, Any]) -> _Node:
    """A node of a resolved model with other defaults of the parameters in it, by name in ROS."""
    known: dict[int, tuple[Any, Any]] = {}

    def copy(node: Any) -> Any:
        if isinstance(node, tree.RosParameter):
            return replace(node, default=_of_type(changed.get(node.name, node.default), node.type))
        if not isinstance(node, tuple) and (not is_dataclass(node) or isinstance(node, Span)):
            return node
        if id(node) not in known:
            known[id(node)] = node, parts(node)
        return known[id(node)][1]

    def parts(node: Any) -> Any:
        if isinstance(node, tuple):
            return tuple(map(copy, node))
        found = {f.name: getattr(node, f.name) for f in fields(node)}
        copies = {name: copy(part) for name, part in found.items()}
        return replace(node, **{n: c for n, c in copies.items() if c is not found[n]})

    result: _Node = copy(node)
    return result
