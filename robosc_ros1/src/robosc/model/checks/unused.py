"""Checks for names that are declared and never used."""

from __future__ import annotations

from collections.abc import Iterable

from robosc import errors, source
from robosc.expr import tree, types
from robosc.expr.traversal import walk_all
from robosc.language.events import EventKind, Kind
from robosc.model.declarations.state_variables import all_expressions
from robosc.model.declarations.type_declarations import TypeDeclarations
from robosc.model.diagnostics import Report
from robosc.model.entities import Robot
from robosc.model.names.scope import FileScope
from robosc.model.names.tables import CommunicationInfo, ComponentTable
from robosc.model.names.value_scope import ValueScope
from robosc.syntax.nodes import ConditionNode, ConstantNode, FunctionNode, Name, ParameterNode

# Checks of names that may be confused: of one spelling but for case, of one topic.


def check_case(scope: FileScope, component_table: ComponentTable, report: Report) -> None:
    """Report names of one kind that differ only in case."""
    _similar((c.name for c in scope.components.values()), "components", report)
    _similar((d.name for d in scope.datatypes.values()), "datatypes", report)
    _similar((i.name for i in scope.interfaces.values()), "interfaces", report)
    local = [i for i in component_table.instances.values() if i.imported is None]
    communications = [c.node.name for i in local for c in i.communications.values()]
    _similar(communications, "communications", report)
    for instance in local:
        _similar((s.name for s in instance.states.values()), "states", report)
        _similar((v.name for v in instance.variable_nodes.values()), "variables", report)
    for datatype in scope.datatypes.values():
        rules = getattr(datatype, "rules", ())
        _similar((r.value for r in rules), "enum values", report)
        properties = getattr(datatype, "properties", ())
        _similar((p.name for p in properties), "properties", report)


def _similar(names: Iterable[Name], what: str, report: Report) -> None:
    seen: dict[str, Name] = {}
    for name in names:
        first = seen.setdefault(name.text.casefold(), name)
        if first.text != name.text:
            report.add(
                "names-differ-in-case",
                name.span,
                f"the {what} '{first.text}' and '{name.text}' differ only in case",
                None,
                [errors.Note("the other one is here", first.span)],
            )


def check_topics(component_table: ComponentTable, report: Report) -> None:
    """Report messages on one topic that have different types, or of which two are received."""
    first: dict[str, CommunicationInfo] = {}
    outgoing: dict[str, CommunicationInfo] = {}
    for instance in component_table.instances.values():
        for info in instance.communications.values():
            if info.entity is None or info.sort.folder != "msg":
                continue
            other = first.setdefault(info.entity.ros_name, info)
            _check_topic_types(other, info, report)
            if info.kind is Kind.OUTGOING:
                sender = outgoing.setdefault(info.entity.ros_name, info)
                if sender is not info and not (sender.misdirected or info.misdirected):
                    _shared_topic(sender, info, report)


def _check_topic_types(first: CommunicationInfo, second: CommunicationInfo, report: Report) -> None:
    assert first.entity is not None and second.entity is not None
    one, two = (f"{e.binding.package}/{e.binding.type}" for e in (first.entity, second.entity))
    if one != two:
        report.add(
            "topic-types",
            _topic_span(second),
            f"topic '{second.entity.identifier}' carries {two} here and {one} elsewhere",
            "ROS connects only publishers and subscribers of one type",
            [errors.Note("the other message is here", _topic_span(first))],
        )


def _shared_topic(first: CommunicationInfo, second: CommunicationInfo, report: Report) -> None:
    assert second.entity is not None
    report.add(
        "topic-shared",
        _topic_span(second),
        f"'{first.key}' and '{second.key}' are received on one topic,"
        f" '{second.entity.identifier}': each message counts as both",
        "use one communication, to which any component can react",
        [errors.Note("the other message is here", _topic_span(first))],
    )


def _topic_span(info: CommunicationInfo) -> source.Span:
    """The place that gives a message its topic: the import, for a component of a library."""
    imported = info.instance.imported
    if imported is not None:
        return (imported.prefix or imported.component).span
    return (info.node.identifier or info.node.name).span


def check_unused(
    scope: FileScope,
    values: ValueScope,
    component_table: ComponentTable,
    robot: Robot,
    type_declarations: TypeDeclarations,
    report: Report,
) -> None:
    """Report the names of this file that nothing uses; ``values`` are those of the file itself.

    To be called for a model without errors only.
    """
    if scope.node.kind == "library":
        return  # whoever imports it may use them
    for name, datatype in scope.datatypes.items():
        if name not in scope.used_datatypes:
            report.add("unused-datatype", datatype.name.span, f"datatype '{name}' is never used")
    for name, interface in scope.interfaces.items():
        if name not in scope.used_interfaces:
            report.add("unused-interface", interface.name.span, f"interface '{name}' is never used")
    expressions = list(all_expressions(robot))
    _check_values(scope, values, component_table, report)
    _check_variables(component_table, expressions, report)
    _check_timeouts(robot, expressions, report)
    _check_enum_values(scope, expressions, type_declarations, report)


def _check_values(
    scope: FileScope, values: ValueScope, component_table: ComponentTable, report: Report
) -> None:
    """Report unused constants, parameters and named conditions."""
    own = [i.types.values for i in component_table.instances.values() if i.imported is None]
    nodes = {
        node.name.span.start: node
        for found in (values, *own)
        for node in (*found.nodes, *found.functions.values())
    }
    for node in nodes.values():
        if not scope.names.is_used(node):
            report.add(
                "unused-value",
                node.name.span,
                f"{_WORDS[type(node)]} '{node.name.text}' is never used",
                "use it or remove it",
            )


_WORDS = {
    ConstantNode: "constant",
    ParameterNode: "parameter",
    ConditionNode: "condition",
    FunctionNode: "function",
}


def _check_variables(
    component_table: ComponentTable, expressions: Iterable[tree.Expr], report: Report
) -> None:
    read = {part.key for part in walk_all(expressions) if isinstance(part, tree.VariableRef)}
    own = [i for i in component_table.instances.values() if i.imported is None]
    # Copies of a component share their declarations: a variable is read if that of one copy is.
    read_at = {
        node.name.span.start
        for instance in own
        for name, node in instance.variable_nodes.items()
        if f"{instance.name}.{name}" in read
    }
    for instance in own:
        for name, node in instance.variable_nodes.items():
            if node.name.span.start not in read_at:
                report.add(
                    "unused-variable",
                    node.name.span,
                    f"variable '{name}' is never read",
                    "only guards, requirements, provide statements and assignments read variables",
                )


def _check_timeouts(robot: Robot, expressions: Iterable[tree.Expr], report: Report) -> None:
    """Report timeouts of messages that nothing reacts to; those of services are deadlines."""
    noticed = {
        transition.communication
        for component in robot.components
        for transition in component.transitions
        if transition.event is EventKind.TIMEOUT
    }
    noticed |= {p.communication for p in walk_all(expressions) if isinstance(p, tree.PhaseRef)}
    timed = [
        c
        for component in robot.components
        for c in component.communications
        if component.library is None and c.kind is Kind.OUTGOING and c.timeout is not None
    ]
    # Copies of a component share their declarations.
    noticed_at = {communication.span for communication in timed if communication.key in noticed}
    for message in timed:
        assert message.timeout is not None
        if message.span not in noticed_at and message.timeout.span is not None:
            noticed_at.add(message.span)
            report.add(
                "unused-timeout",
                message.timeout.span,
                f"nothing reacts when '{message.name}' falls silent",
                f"add 'requirement COMMAND needs {robot.display_names[message.key]}.fresh', or"
                f" react to it: 'on timeout from {message.name} goto STATE'",
            )


def _check_enum_values(
    scope: FileScope,
    expressions: list[tree.Expr],
    type_declarations: TypeDeclarations,
    report: Report,
) -> None:
    """Report the values of enums of which no expression names any, except for the default."""
    named: set[str] = set()
    compared: set[str] = set()
    for part in walk_all(expressions):
        match part:
            case tree.Literal(type=types.EnumType(name=name, origin=origin)):
                if origin == scope.origin:
                    named.add(name)
            case tree.Binary(left=left, right=right) if isinstance(left.type, types.EnumType):
                if not isinstance(left, tree.Literal) and not isinstance(right, tree.Literal):
                    compared.add(left.type.name)
    for name in scope.datatypes:
        node = type_declarations.nodes[scope.origin, name]
        rules = getattr(node, "rules", ())
        if name not in scope.used_datatypes or name in compared or name in named:
            continue
        seen = {rule.value.text for rule in rules if rule.condition is None}
        for rule in rules:
            value = rule.value.text
            if value not in seen:
                report.add(
                    "unused-enum-value", rule.value.span, f"the value '{value}' is never used"
                )
            seen.add(value)
