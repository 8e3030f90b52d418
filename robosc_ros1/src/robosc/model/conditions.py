"""Typing of conditions over a resolved robot, as those in its model are typed.

The simulator gets them from a person or a script: ``Motor.moving and Sensor.way = free``.
"""

from __future__ import annotations

from robosc.model.datatypes import TypeTable
from robosc.model.diagnostics import Report
from robosc.model.entities import Communication, Component, Robot
from robosc.model.expected import BOOLEAN
from robosc.model.expr import Expr
from robosc.model.expressions import Typer
from robosc.model.incoming import no_value
from robosc.model.scope import FileScope
from robosc.model.tables import CommunicationInfo, ComponentTable, Instance, SymbolTable
from robosc.model.type_declarations import TypeDeclarations
from robosc.model.types import EnumType
from robosc.source import Source, Span
from robosc.syntax.nodes import (
    BasicTypeNode,
    ComponentNode,
    ExprNode,
    FileNode,
    Name,
    ServiceNode,
    StateNode,
)

__all__ = ["typed_condition"]

_NOWHERE = Span(Source("", ""), 0, 0)
_NONE = BasicTypeNode("none", span=_NOWHERE)


def typed_condition(node: ExprNode, robot: Robot, report: Report) -> Expr | None:
    """The typed condition, with the scope of a requirement; None after a reported error."""
    name = Name(robot.name, span=_NOWHERE)
    scope = FileScope(_NOWHERE.source, FileNode("robot", name, (), span=_NOWHERE))
    types = TypeTable(scope, TypeDeclarations(), report, lambda types, node, source: None)
    for enum in _enums(robot):
        types.add_enum(enum)
    table = ComponentTable()
    for component in robot.components:
        table.add(_instance(component, types))
    table.index_communications()
    incoming = no_value("a condition on states has no received value")
    return Typer(report, types, SymbolTable(table), incoming).check(node, BOOLEAN, "a condition")


def _enums(robot: Robot) -> list[EnumType]:
    found = {
        variable.type
        for component in robot.components
        for variable in component.variables
        if isinstance(variable.type, EnumType)
    }
    return sorted(found, key=lambda enum: (enum.name, enum.origin))


def _instance(component: Component, types: TypeTable) -> Instance:
    name = Name(component.name, span=_NOWHERE)
    instance = Instance(component.name, ComponentNode(name, (), span=_NOWHERE), types)
    for state in component.states:
        node = StateNode(Name(state.name, span=_NOWHERE), False, False, (), span=_NOWHERE)
        instance.states[state.name] = node
    for variable in component.variables:
        instance.variables[variable.name] = variable.type
    for communication in component.communications:
        instance.communications[communication.name] = _info(communication, instance)
    return instance


def _info(found: Communication, instance: Instance) -> CommunicationInfo:
    node = ServiceNode(Name(found.name, span=_NOWHERE), None, _NONE, _NONE, None, span=_NOWHERE)
    return CommunicationInfo(
        node, instance, found.kind, found.request, found.response, found.feedback, found
    )
