"""Checks of the whole model: finite state variables, unused names, shared topics."""

from __future__ import annotations

from collections.abc import Collection, Iterable, Iterator
from dataclasses import dataclass, replace

from robosc.errors import Note
from robosc.language.events import EventKind
from robosc.model.compatibility import describe
from robosc.model.diagnostics import Report
from robosc.model.entities import (
    Assignment,
    Behaviour,
    Component,
    Kind,
    Preference,
    Provide,
    Requirement,
    Robot,
    data_expressions,
)
from robosc.model.expr import (
    Binary,
    Convert,
    Expr,
    Literal,
    Operation,
    ParameterRef,
    Part,
    PhaseRef,
    ValueRef,
    VariableRef,
)
from robosc.model.scope import FileScope
from robosc.model.tables import CommunicationInfo, ComponentTable
from robosc.model.traversal import walk, walk_all
from robosc.model.type_declarations import TypeDeclarations
from robosc.model.types import ArrayType, EnumType, ObjectType, domain
from robosc.model.value_scope import ValueScope
from robosc.source import Span
from robosc.syntax.nodes import ConditionNode, ConstantNode, Name, ParameterNode

__all__ = [
    "Model", "all_expressions", "check_case", "check_topics", "check_unused",
    "select_state_variables",
]  # fmt: skip


@dataclass(frozen=True)
class Model:
    """The entities of one file, without those that have errors."""

    components: tuple[Component, ...]
    requirements: tuple[Requirement, ...]
    provides: tuple[Provide, ...]
    preferences: tuple[Preference, ...]


# --- which variables belong to the state ---------------------------------------------------------


def select_state_variables(model: Model, report: Report) -> Model:
    """The model with ``Variable.in_state`` set; report assigned values that are not finite.

    A variable belongs to the state if a guard, a requirement or a provide condition reads it, or
    the right-hand side of an assignment to a finite variable of the state. A variable with an
    infinite domain is abstracted to the comparisons in which it stands: a variable that is copied
    to it belongs to the state as well, but those from which its value is computed do not.
    """
    declared = {v.key: v for c in model.components if c.behaviour for v in c.behaviour.variables}
    data = {key for key, variable in declared.items() if domain(variable.type) is None}
    readers = _state_readers(model, data)
    for component, assignment in _assignments(model):
        key = f"{component.name}.{assignment.variable}"
        if key in readers and key not in data:
            _check_finite(assignment, report)
    components = tuple(_with_state(c, readers) for c in model.components)
    return replace(model, components=components)


def _with_state(component: Component, readers: dict[str, Span]) -> Component:
    behaviour = component.behaviour
    if behaviour is None:
        return component
    variables = tuple(replace(v, in_state=v.key in readers) for v in behaviour.variables)
    return replace(component, behaviour=replace(behaviour, variables=variables))


def _state_readers(model: Model, data: Collection[str]) -> dict[str, Span]:
    """The keys of the variables of the state, each with the first place that reads it."""
    readers: dict[str, Span] = {}
    sources: dict[str, list[VariableRef]] = {}
    for component, assignment in _assignments(model):
        key = f"{component.name}.{assignment.variable}"
        parts = [assignment.value] if key in data else walk(assignment.value)
        sources.setdefault(key, []).extend(r for r in parts if isinstance(r, VariableRef))
    work = [r for r in walk_all(_deciding(model)) if isinstance(r, VariableRef)]
    work.reverse()
    while work:
        ref = work.pop()
        key = f"{ref.component}.{ref.variable}"
        if key not in readers and ref.span is not None:
            readers[key] = ref.span
            work.extend(sources.get(key, ()))
    return readers


def _deciding(model: Model | Robot) -> Iterator[Expr]:
    """Guards, requirements and provide conditions: the expressions that enable events."""
    for component in model.components:
        if component.behaviour is not None:
            yield from _guards(component.behaviour)
    for requirement in model.requirements:
        yield requirement.condition
    for provide in model.provides:
        if provide.condition is not None:
            yield provide.condition


def _guards(behaviour: Behaviour) -> Iterator[Expr]:
    for transition in behaviour.all_transitions:
        if transition.guard is not None:
            yield transition.guard
    yield from (t.guard for t in behaviour.all_taus if t.guard is not None)


def _assignments(model: Model | Robot) -> Iterator[tuple[Component, Assignment]]:
    for component in model.components:
        if component.behaviour is not None:
            for transition in component.behaviour.all_transitions:
                for assignment in transition.assignments:
                    yield component, assignment


def _check_finite(assignment: Assignment, report: Report) -> None:
    """Report what a finite variable takes from an infinite domain, unless it is only compared."""
    for part in _taken(assignment.value):
        reads = isinstance(part, VariableRef | ValueRef | ParameterRef | Part)
        computed = _goes_through_data(part)
        if (reads or computed) and domain(part.type) is None and part.span is not None:
            report.add(
                "not-finite",
                part.span,
                f"'{assignment.variable}' decides about events, so it cannot take"
                f" {describe(part.type)} without a range",
                "compare it here, or convert it by an enum"
                if computed
                else "give it a range, integer(0..9), or convert it by an enum",
            )


def _goes_through_data(expr: Expr) -> bool:
    """Whether an expression has an array or an object as an operand."""
    operands = expr.operands if isinstance(expr, Operation) else ()
    return any(isinstance(operand.type, ArrayType | ObjectType) for operand in operands)


def _taken(expr: Expr) -> Iterator[Expr]:
    """The parts of an expression of which its value consists: not those that it compares."""
    yield expr
    if isinstance(expr, Convert | Part) or _goes_through_data(expr):
        return
    if isinstance(expr, Operation) and not expr.operation.is_comparison:
        for operand in expr.operands:
            yield from _taken(operand)


# --- unused names --------------------------------------------------------------------------------


def check_unused(
    scope: FileScope,
    values: ValueScope,
    component_table: ComponentTable,
    model: Model,
    type_declarations: TypeDeclarations,
    report: Report,
) -> None:
    """Report the names of this file that nothing uses; ``values`` are those of the file itself.

    To be called for a model without errors only.
    """
    for name, datatype in scope.datatypes.items():
        if name not in scope.used_datatypes:
            report.add("unused-datatype", datatype.name.span, f"datatype '{name}' is never used")
    for name, interface in scope.interfaces.items():
        if name not in scope.used_interfaces:
            report.add("unused-interface", interface.name.span, f"interface '{name}' is never used")
    if scope.node.kind == "library":
        return  # whoever imports it may read its variables
    expressions = list(all_expressions(model))
    _check_values(scope, values, component_table, report)
    _check_variables(component_table, expressions, report)
    _check_timeouts(model.components, expressions, report)
    _check_enum_values(scope, expressions, type_declarations, report)


def all_expressions(model: Model | Robot) -> Iterator[Expr]:
    """All expressions of components, requirements and provide statements."""
    yield from _deciding(model)
    for _, assignment in _assignments(model):
        yield assignment.value
    for provide in model.provides:
        yield from data_expressions(provide.data)


def _check_values(
    scope: FileScope, values: ValueScope, component_table: ComponentTable, report: Report
) -> None:
    """Report unused constants, parameters and named conditions."""
    own = [i.types.values for i in component_table.instances.values() if i.imported is None]
    nodes = {node.name.span.start: node for found in (values, *own) for node in found.nodes}
    for node in nodes.values():
        if not scope.names.is_used(node):
            report.add(
                "unused-value",
                node.name.span,
                f"{_WORDS[type(node)]} '{node.name.text}' is never used",
                "use it or remove it",
            )


_WORDS = {ConstantNode: "constant", ParameterNode: "parameter", ConditionNode: "condition"}


def _check_variables(
    component_table: ComponentTable, expressions: Iterable[Expr], report: Report
) -> None:
    read = {
        (part.component, part.variable)
        for part in walk_all(expressions)
        if isinstance(part, VariableRef)
    }
    own = [i for i in component_table.instances.values() if i.imported is None]
    # Copies of a component share their declarations: a variable is read if that of one copy is.
    read_at = {
        node.name.span.start
        for instance in own
        for name, node in instance.variable_nodes.items()
        if (instance.name, name) in read
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


def _check_timeouts(
    components: Iterable[Component], expressions: Iterable[Expr], report: Report
) -> None:
    """Report timeouts of messages that nothing reacts to; those of services are deadlines."""
    behaviours = [c.behaviour for c in components if c.behaviour is not None]
    noticed = {
        transition.communication
        for behaviour in behaviours
        for transition in behaviour.all_transitions
        if transition.event is EventKind.TIMEOUT
    }
    noticed |= {p.communication for p in walk_all(expressions) if isinstance(p, PhaseRef)}
    timed = [
        c
        for component in components
        for c in component.communications
        if component.library is None and c.kind is Kind.OUTGOING and c.timeout is not None
    ]
    # Copies of a component share their declarations.
    noticed_at = {communication.span for communication in timed if communication.key in noticed}
    for message in timed:
        assert message.timeout is not None
        if message.span not in noticed_at and message.timeout.span is not None:
            report.add(
                "unused-timeout",
                message.timeout.span,
                f"nothing reacts when '{message.name}' falls silent",
                f"add 'requirement COMMAND needs {message.name}.fresh', or react to it:"
                f" 'on timeout from {message.name} goto STATE'",
            )


def _check_enum_values(
    scope: FileScope,
    expressions: list[Expr],
    type_declarations: TypeDeclarations,
    report: Report,
) -> None:
    """Report the values of enums of which no expression names any, except for the default."""
    named: set[str] = set()
    compared: set[str] = set()
    for part in walk_all(expressions):
        match part:
            case Literal(type=EnumType(name=name, origin=origin)):
                if origin == scope.origin:
                    named.add(name)
            case Binary(left=left, right=right) if isinstance(left.type, EnumType):
                if not isinstance(left, Literal) and not isinstance(right, Literal):
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


# --- names and topics ----------------------------------------------------------------------------


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
                [Note("the other one is here", first.span)],
            )


def check_topics(component_table: ComponentTable, report: Report) -> None:
    """Report messages on one topic that have different types, or of which two are received."""
    first: dict[str, CommunicationInfo] = {}
    outgoing: dict[str, CommunicationInfo] = {}
    for instance in component_table.instances.values():
        for info in instance.communications.values():
            if info.entity is None or info.kind in (Kind.SERVICE, Kind.ACTION):
                continue
            other = first.setdefault(info.entity.identifier, info)
            _check_topic_types(other, info, report)
            if info.kind is Kind.OUTGOING:
                sender = outgoing.setdefault(info.entity.identifier, info)
                if sender is not info:
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
            [Note("the other message is here", _topic_span(first))],
        )


def _shared_topic(first: CommunicationInfo, second: CommunicationInfo, report: Report) -> None:
    assert second.entity is not None
    report.add(
        "topic-shared",
        _topic_span(second),
        f"'{first.key}' and '{second.key}' are received on one topic,"
        f" '{second.entity.identifier}': each message counts as both",
        "use one communication, to which any component can react",
        [Note("the other message is here", _topic_span(first))],
    )


def _topic_span(info: CommunicationInfo) -> Span:
    """The place that gives a message its topic: the import, for a component of a library."""
    imported = info.instance.imported
    if imported is not None:
        return (imported.prefix or imported.component).span
    return (info.node.identifier or info.node.name).span
