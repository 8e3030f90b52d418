"""Declaration of components: their communications, variables and states by name.

All components of a file are declared before any behaviour is resolved, so that declarations can
refer forwards.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from typing import TypeVar

from robosc.errors import Note
from robosc.expr import evaluation, tree, undefined_data
from robosc.expr.types import ArrayType, EnumType, NoneType, Type, innermost
from robosc.language.events import COMMUNICATIONS, Direction
from robosc.model.diagnostics import Report
from robosc.model.entities import Communication
from robosc.model.names.occurrences import kind_of, types_of
from robosc.model.names.tables import (
    CommunicationInfo,
    ComponentTable,
    Instance,
    SymbolTable,
    path_of,
)
from robosc.model.ros.links import Binder, Payload, is_legal
from robosc.model.typing.durations import DURATION, is_long_enough
from robosc.model.typing.expected import BOOLEAN
from robosc.model.typing.expressions import Typer
from robosc.model.typing.value_word import EXPECTATION, no_value, response_of
from robosc.names import is_frame, ros_name_fault, snake_case
from robosc.runtime.core import settings, transforms
from robosc.source import Span
from robosc.syntax import nodes
from robosc.syntax.nodes import BehaviourNode, ComponentNode, StateNode

# Which states are initial where that depends on the copy: ``initial state a if index = 1``.


_Node = TypeVar("_Node", ComponentNode, BehaviourNode, StateNode)


def with_initial_states(instance: Instance, report: Report) -> ComponentNode:
    """Return the component with states that are initial where their conditions hold."""
    return _resolved(instance.node, instance, report)


def _resolved(node: _Node, instance: Instance, report: Report) -> _Node:
    items = tuple(
        _resolved(item, instance, report) if isinstance(item, BehaviourNode | StateNode) else item
        for item in node.items
    )
    same = all(a is b for a, b in zip(items, node.items, strict=True))
    changed = node if same else replace(node, items=items)
    if isinstance(changed, StateNode) and changed.when is not None:
        return replace(changed, initial=_holds(changed, instance, report))
    return changed


def _holds(node: StateNode, instance: Instance, report: Report) -> bool:
    assert node.when is not None
    typer = Typer(report, instance.types, None, no_value("where a state is initial has no 'value'"))
    found = typer.check(node.when, BOOLEAN, "where a state is initial")
    value = None if found is None else evaluation.constant(found)
    if found is not None and value is None:
        report.add(
            "initial-not-constant",
            node.when.span,
            f"where '{node.name.text}' is initial must be known before the robot runs",
            "read the index and constants only",
        )
    return bool(value)


NONE = NoneType()
TRANSFORM_RATE = 20.0
"""How often a transform comes at most, in Hz, if the model does not say."""


def join(prefix: str, name: str) -> str:
    """The ROS name below a prefix: ``/left/cmd`` for ``/left`` and ``/cmd``."""
    return f"{prefix.rstrip('/')}/{name.lstrip('/')}" if prefix else name


def declare(instance: Instance, report: Report) -> None:
    """Fill the tables of an instance from its node."""
    for item in instance.node.items:
        if isinstance(item, nodes.BehaviourNode):
            if instance.behaviour is not None:
                report.add(
                    "several-behaviours",
                    _head(item, "behaviour"),
                    f"component {instance.name} already has a behaviour",
                    "merge them into one",
                    [Note("the first one is here", _head(instance.behaviour, "behaviour"))],
                )
                instance.types.scope.mark_unresolved(item)
                instance.duplicate_behaviours.append(item)
                continue
            instance.behaviour = item
            _declare_behaviour(instance, item, report)
        elif isinstance(item, nodes.MessageNode | nodes.ServiceNode | nodes.ActionNode):
            _declare_communication(instance, item, report)


def _head(node: nodes.BehaviourNode, keyword: str) -> Span:
    """The span of the keyword with which a node begins."""
    return Span(node.span.source, node.span.start, node.span.start + len(keyword))


def _declare_behaviour(instance: Instance, node: nodes.BehaviourNode, report: Report) -> None:
    names = instance.types.scope.names
    for item in node.items:
        match item:
            case nodes.StateNode():
                _declare_state(instance, item, "", report)
            case nodes.VariableNode(name=name):
                names.declare(item, instance.name)
                if name.text in instance.variables:
                    first = instance.variable_nodes[name.text]
                    _duplicate("variable", item, first, instance, report)
                else:
                    instance.variables[name.text] = _variable_type(instance, item, report)
                    instance.variable_nodes[name.text] = item


def _declare_state(instance: Instance, node: nodes.StateNode, inside: str, report: Report) -> None:
    """Enter a state and those in it; ``inside`` is the path of the one around it."""
    instance.types.scope.names.declare(node, instance.name)
    path = path_of(node, inside)
    if path in instance.states:
        _duplicate("state", node, instance.states[path], instance, report)
        return
    instance.states[path] = node
    for state in node.states:
        _declare_state(instance, state, path, report)


def _duplicate(
    what: str,
    second: nodes.StateNode | nodes.VariableNode | nodes.CommunicationNode,
    first: nodes.StateNode | nodes.VariableNode | nodes.CommunicationNode,
    instance: Instance,
    report: Report,
) -> None:
    report.add(
        "duplicate-name",
        second.name.span,
        f"component {instance.name} already has a {what} '{second.name.text}'",
        "give one of them another name",
        [Note("the first one is here", first.name.span)],
    )


def _variable_type(instance: Instance, node: nodes.VariableNode, report: Report) -> Type | None:
    type_ = instance.types.resolve(node.type)
    if not isinstance(type_, NoneType):
        return type_
    report.add(
        "variable-type",
        node.type.span,
        f"variable '{node.name.text}' cannot be of type none",
        "use any other type",
    )
    return None


# --- communications ------------------------------------------------------------------------------


def _declare_communication(
    instance: Instance, node: nodes.CommunicationNode, report: Report
) -> None:
    name = node.name.text
    instance.types.scope.names.declare(node, instance.name)
    if name in instance.communications:
        first = instance.communications[name].node
        _duplicate("communication", node, first, instance, report)
        return
    types: dict[Direction, Type | None] = {"request": NONE, "response": NONE, "feedback": NONE}
    kind = kind_of(node)
    sent = COMMUNICATIONS[kind].sent
    for direction, type_node in types_of(node).items():
        types[direction] = _carried(instance, type_node, report, sent=direction in sent)
    instance.communications[name] = CommunicationInfo(
        node, instance, kind, types["request"], types["response"], types["feedback"]
    )


def _carried(
    instance: Instance, node: nodes.TypeNode, report: Report, *, sent: bool
) -> Type | None:
    """The type of a communication's data; None after an error."""
    type_ = instance.types.resolve(node)
    if isinstance(type_, ArrayType):
        report.add(
            "array-not-allowed",
            node.span,
            "a communication does not carry an array directly",
            "use an object that has the array as a property, or an enum from it",
        )
        return None
    if type_ is not None and not instance.types.type_declarations.is_known(type_):
        return None
    if sent and type_ is not None:
        return _sendable(type_, node.span, report)
    return type_


def _sendable(type_: Type, span: Span, report: Report) -> Type | None:
    """The type of data that is sent; None after reporting an enum in it."""
    if isinstance(type_, EnumType):
        report.add(
            "enum-sent",
            span,
            f"{type_} cannot be sent: an enum only converts received data",
            f"use the type that it converts from: {type_.source}",
        )
        return None
    for path, part in innermost(type_):
        if isinstance(part, EnumType):
            place = ".".join((str(type_), *path))
            report.add(
                "enum-sent",
                span,
                f"{type_} cannot be sent: {place} is the enum {part}, which only converts received"
                " data",
                f"declare an object for sending, with {part.source} in its place",
            )
            return None
    return type_


def check_local_names(component_table: ComponentTable, report: Report) -> None:
    """Report communications of this file's components that have the same name."""
    for infos in component_table.by_name.values():
        local = [i for i in infos if i.instance.imported is None and i.instance.node.copy is None]
        for info in local[1:]:
            report.add(
                "duplicate-name",
                info.node.name.span,
                f"component {local[0].instance.name} already has a communication '{info.name}'",
                "communications of a robot have different names; 'identifier:' may be the same",
                [Note("the first one is here", local[0].node.name.span)],
            )


def bind(info: CommunicationInfo, symbols: SymbolTable, binder: Binder, report: Report) -> None:
    """Resolve identifier, durations and interface of a communication, and set its entity."""
    identifier = _identifier(info, report)
    timeout = _duration(info, "timeout", "a timeout", symbols, report)
    max_age = _duration(info, "max_age", "'max_age:'", symbols, report)
    within = _duration(info, "within", "'within:'", symbols, report)
    expect = _expectation(info, report)
    rate = None if info.node.rate is None else _rate(info.node.rate, report)
    goals = getattr(info.node, "goals", None)
    stop = getattr(info.node, "stop", None)
    frames = None
    if isinstance(info.node, nodes.TransformNode):
        frames = _frames(info.node, report)
        rate = TRANSFORM_RATE if rate is None else rate
    interface, known = _interface(info, report)
    if info.request is None or info.response is None or info.feedback is None or not known:
        return
    binding = binder.bind(info.key, info.node, tuple(_payloads(info)), interface)
    if binding is None or identifier is None:
        return
    if isinstance(info.node, nodes.MessageNode) and info.node.max_age is not None:
        binder.check_header(binding, info.node.max_age.span)
    info.entity = Communication(
        info.name,
        info.instance.name,
        info.kind,
        identifier,
        info.request,
        info.response,
        info.feedback,
        binding,
        timeout,
        within,
        max_age,
        expect,
        rate,
        None if goals is None else goals.text,
        None if stop is None else stop.text,
        frames,
        span=info.node.name.span,
    )


def _duration(
    info: CommunicationInfo, attribute: str, what: str, symbols: SymbolTable, report: Report
) -> tree.Expr | None:
    """The duration of an attribute; None if there is none, or after an error."""
    node = getattr(info.node, attribute, None)
    if node is None:
        return None
    typer = Typer(report, info.instance.types, symbols, no_value(f"{what} is a duration"))
    found = typer.check(node, DURATION, what)
    return found if found and is_long_enough(found, what, node.span, report) else None


def _rate(node: nodes.RateNode | nodes.Name, report: Report) -> float | str:
    """What ``rate:`` says: how often per second, or ``once``."""
    if isinstance(node, nodes.Name):
        return node.text
    if node.hertz <= 0:
        report.add("out-of-range", node.span, "a rate is more than 0 Hz", "write: once")
    elif node.hertz > settings.FASTEST:
        text = f"a rate is at most {settings.FASTEST:g} Hz: no command is repeated faster"
        report.add("out-of-range", node.span, text)
    return float(node.hertz)


def _expectation(info: CommunicationInfo, report: Report) -> tree.Expr | None:
    """What an ``expect:`` says of a response; None if there is none, or after an error."""
    node = getattr(info.node, "expect", None)
    if node is None:
        return None
    incoming = response_of(info.name, info.response)
    found = Typer(report, info.instance.types, None, incoming).check(node, BOOLEAN, EXPECTATION)
    return None if found is None else undefined_data.condition_on_data(found)


def _payloads(info: CommunicationInfo) -> Iterator[Payload]:
    written = types_of(info.node)
    for direction, type_ in info.types.items():
        assert type_ is not None
        yield Payload(type_, written[direction], direction, direction in info.sort.sent)


def _interface(
    info: CommunicationInfo, report: Report
) -> tuple[nodes.InterfaceNode | nodes.RosTypeNode | None, bool]:
    """The linked interface or ROS type, and whether the link is free of errors."""
    links = info.node.links
    scope = info.instance.types.scope
    type_ = info.node.type if isinstance(info.node, nodes.MessageNode) else info.node.request
    if links is None and isinstance(type_, nodes.RosTypeNode):
        return type_, True
    if links is None:
        return None, not scope.is_cut_short(info.node.span)
    owner = info.instance.types.owner(links)
    found = None if owner is None else owner.scope.interfaces.get(links.name.text)
    scope.names.use(links.name, found)
    if owner is not None:
        owner.scope.used_interfaces.add(links.name.text)
        if links.library is not None:
            scope.names.use(links.library, owner.scope.node)
    if found is None:
        unknown = links.library if links.library is not None and owner is None else links.name
        if not scope.is_unresolved(unknown.text, "interface"):
            name = links.name.text
            hint = None if owner is None else report.suggest(name, owner.scope.interfaces)
            report.add(
                "unknown-interface",
                unknown.span,
                f"there is no interface '{links.span.text}'",
                hint or f"declare: interface {name} use TYPE from PACKAGE",
            )
        return None, False
    return found, is_legal(found)


def _frames(node: nodes.TransformNode, report: Report) -> tuple[str, str] | None:
    """The frames of a transform, as their names are compared."""
    assert node.source and node.target
    source, target = (transforms.plain(name.text) for name in (node.source, node.target))
    for name in (node.source, node.target):
        if not is_frame(transforms.plain(name.text)):
            text = f"{name.span.text} is no name of a frame"
            report.add("frames", name.span, text, 'write it as in /tf, such as "base_link"')
    if source == target:
        text = f"the transform '{node.name.text}' is from a frame to itself"
        report.add("frames", node.target.span, text, "name the frame whose pose it gives")
    if isinstance(node.rate, nodes.Name):
        text = "a transform comes by itself, and 'rate:' says how often at most"
        report.add("frames", node.rate.span, text, "write: 20 Hz")
    return source, target


def _identifier(info: CommunicationInfo, report: Report) -> str | None:
    if isinstance(info.node, nodes.TransformNode):
        assert info.node.source and info.node.target
        source, target = info.node.source.text, info.node.target.text
        return f"/tf from {transforms.plain(source)} to {transforms.plain(target)}"
    written: nodes.StringNode | None = info.node.identifier
    name = written.text if written is not None else info.name
    if written is None and info.instance.node.copy is not None:
        name = f"{snake_case(info.instance.name)}/{name}"
    span = written.span if written is not None else info.node.name.span
    fault = ros_name_fault(name)
    if fault is not None:
        hint = None if written is not None else 'add: identifier: "a_name_that_ros_allows",'
        report.add("ros-name", span, f"ROS does not allow the name {name!r}: {fault}", hint)
        return None
    prefix = info.instance.prefix
    return None if prefix is None else join(prefix, name)


def check_prefix(node: nodes.StringNode, report: Report) -> str | None:
    """The text of a prefix; None after an error."""
    text = node.text
    stripped = text.rstrip("/")
    fault = None if text in ("", "/") else ros_name_fault(stripped)
    if fault is not None:
        report.add("ros-name", node.span, f"ROS does not allow the prefix {text!r}: {fault}")
        return None
    return text


def check_interfaces(interfaces: dict[str, nodes.InterfaceNode], report: Report) -> None:
    """Report names of types and packages that ROS does not allow."""
    for node in interfaces.values():
        for name, what in ((node.type, "type"), (node.package, "package")):
            if not name.text[0].isalpha():
                report.add(
                    "ros-name",
                    name.span,
                    f"ROS does not allow the {what} name '{name.text}': it begins with '_'",
                )
