"""From a place in a text to what stands there means: every name of a file, resolved.

Where the resolver has settled a name (an enum value that two enums have, say), its typed
expressions tell; in parts with faults the name is looked up as well as it can be.
"""

from __future__ import annotations

from bisect import bisect_right
from collections.abc import Iterator
from dataclasses import dataclass, field
from functools import cached_property

from robosc.lsp.declared import Declared
from robosc.lsp.symbols import Occurrence, Symbol, SymbolKind
from robosc.model.entities import Behaviour, Data, DataObject, State
from robosc.model.expr import Expr, Literal, StateRef, VariableRef, walk
from robosc.model.expressions import is_value
from robosc.model.resolve import ResolvedFile
from robosc.model.rosmsg import MessageDefinitions
from robosc.model.tables import CommunicationInfo, Instance
from robosc.model.types import ArrayType, EnumType, ObjectType, Type
from robosc.source import Source, Span
from robosc.syntax.nodes import (
    Access,
    ActionNode,
    ArrayTypeNode,
    BehaviourNode,
    BinaryNode,
    CommunicationNode,
    ComponentNode,
    DataFieldNode,
    DataNode,
    DataObjectNode,
    EnumNode,
    ExprNode,
    FileNode,
    ImportNode,
    InterfaceNode,
    MessageNode,
    Name,
    NamedTypeNode,
    ObjectNode,
    ProvideNode,
    RequirementNode,
    ResultTransitionNode,
    ServiceNode,
    StateNode,
    TauNode,
    TypeNode,
    UnaryNode,
    VariableNode,
)

__all__ = ["Index", "build_index"]


@dataclass(frozen=True)
class Index:
    """The names of one file in reading order, and what can be asked about them."""

    occurrences: tuple[Occurrence, ...] = ()
    declared: Declared | None = None
    uses: tuple[tuple[str, Span], ...] = field(default=())
    """Requirements by the key of each communication that they are about."""

    @cached_property
    def _starts(self) -> list[int]:
        return [o.span.start for o in self.occurrences]

    def at(self, offset: int) -> Occurrence | None:
        """The name at an offset; one that ends there counts too, unless another one begins."""
        place = bisect_right(self._starts, offset) - 1
        if place < 0:
            return None
        found = self.occurrences[place]
        return found if found.span.end >= offset else None

    def of(self, symbol: Symbol) -> Iterator[Occurrence]:
        """Where a symbol is named in this file."""
        key = symbol.key
        for occurrence in self.occurrences:
            other = occurrence.symbol
            if other.key == key if key is not None else other == symbol:
                yield occurrence


def build_index(file: ResolvedFile, definitions: MessageDefinitions) -> Index:
    """The index of a file that was read; empty if nothing of it could be."""
    if file.scope is None or file.types is None or file.component_table is None:
        return Index()
    declared = Declared(file, definitions)
    builder = _Builder(declared, _typed(file, file.scope.source))
    builder.file(file.scope.node)
    unique = {(o.span.start, o.span.end): o for o in builder.found}
    ordered = sorted(unique.values(), key=lambda o: o.span.start)
    return Index(tuple(ordered), declared, tuple(builder.uses))


def _typed(file: ResolvedFile, source: Source) -> dict[tuple[int, int], Expr]:
    """The leaves of all typed expressions by their place in the file."""
    found: dict[tuple[int, int], Expr] = {}
    for expr in _expressions(file):
        for part in walk(expr):
            if isinstance(part, Literal | StateRef | VariableRef):
                span = part.span
                if span is not None and span.source is source:
                    found[span.start, span.end] = part
    return found


def _expressions(file: ResolvedFile) -> Iterator[Expr]:
    assert file.scope is not None and file.types is not None
    for name in file.scope.datatypes:
        known = file.types.known(name)
        if isinstance(known, EnumType):
            yield from (rule.condition for rule in known.rules)
    if file.model is None:
        return
    for component in file.model.components:
        behaviour = component.behaviour
        if behaviour is None:
            continue
        groups: tuple[Behaviour | State, ...] = (behaviour, *behaviour.states)
        for group in groups:
            for result in group.transitions:
                yield from () if result.guard is None else (result.guard,)
                yield from (a.value for a in result.assignments)
            yield from (t.guard for t in group.taus if t.guard is not None)
    yield from (requirement.condition for requirement in file.model.requirements)
    for provide in file.model.provides:
        yield from () if provide.condition is None else (provide.condition,)
        yield from _leaves(provide.data)


def _leaves(data: Data) -> Iterator[Expr]:
    if isinstance(data, DataObject):
        for _, inner in data.fields:
            yield from _leaves(inner)
    else:
        yield data


class _Builder:
    """Walks the tree of a file and notes each name with its meaning."""

    def __init__(self, declared: Declared, typed: dict[tuple[int, int], Expr]) -> None:
        self.found: list[Occurrence] = []
        self.uses: list[tuple[str, Span]] = []
        self._declared = declared
        self._typed = typed
        self._own: Instance | None = None

    def _note(
        self, name: Name, symbol: Symbol | None, *, declaration: bool = False, write: bool = False
    ) -> None:
        if symbol is not None:
            self.found.append(Occurrence(name.span, symbol, declaration, write))

    # --- declarations ----------------------------------------------------------------------------

    def file(self, node: FileNode) -> None:
        kind = SymbolKind.ROBOT if node.kind == "robot" else SymbolKind.LIBRARY
        self._note(
            node.name,
            Symbol(kind, node.name.text, "", node.name.span, node.span, node.kind),
            declaration=True,
        )
        for item in node.declarations:
            self._own = None
            match item:
                case ComponentNode():
                    self._component(item)
                case ImportNode():
                    self._import(item)
                case RequirementNode():
                    self._requirement(item)
                case ProvideNode():
                    self._provide(item)
                case ObjectNode():
                    self._object(item)
                case EnumNode():
                    self._enum(item)
                case InterfaceNode():
                    self._interface(item)

    def _component(self, node: ComponentNode) -> None:
        self._own = self._declared.instance(node)
        self._note(node.name, self._declared.component_node(node), declaration=True)
        for item in node.items:
            if isinstance(item, BehaviourNode):
                self._behaviour(item)
            else:
                self._communication(node, item)

    def _import(self, node: ImportNode) -> None:
        self._note(node.name, self._declared.import_node(node), declaration=True)
        self._note(node.library, self._declared.library(node))
        self._note(node.component, self._declared.imported(node))

    def _communication(self, owner: ComponentNode, node: CommunicationNode) -> None:
        symbol = self._declared.communication_node(owner.name.text, node)
        self._note(node.name, symbol, declaration=True)
        match node:
            case MessageNode():
                self._type(node.type)
            case ServiceNode():
                self._types(node.request, node.response)
            case ActionNode():
                self._types(node.request, node.response, node.feedback)
        if node.links is not None:
            self._note(node.links, self._declared.interface(node.links.text))

    def _object(self, node: ObjectNode) -> None:
        self._note(node.name, self._declared.datatype_node(node), declaration=True)
        for prop in node.properties:
            symbol = self._declared.property_node(node.name.text, prop)
            self._note(prop.name, symbol, declaration=True)
            self._type(prop.type)

    def _enum(self, node: EnumNode) -> None:
        self._note(node.name, self._declared.datatype_node(node), declaration=True)
        self._type(node.source)
        source = self._declared.type_of(node.source)
        for rule in node.rules:
            symbol = self._declared.value_of(node, rule.value.text)
            first = symbol is not None and symbol.declared == rule.value.span
            self._note(rule.value, symbol, declaration=first)
            if rule.condition is not None:
                self._expression(rule.condition, source)

    def _interface(self, node: InterfaceNode) -> None:
        self._note(node.name, self._declared.interface(node.name.text), declaration=True)
        package, type_ = node.package.text, node.type.text
        self._note(node.type, Symbol(SymbolKind.ROS_TYPE, type_, package))
        self._note(node.package, Symbol(SymbolKind.ROS_PACKAGE, package))

    def _types(self, *nodes: TypeNode) -> None:
        for node in nodes:
            self._type(node)

    def _type(self, node: TypeNode) -> None:
        while isinstance(node, ArrayTypeNode):
            node = node.element
        if isinstance(node, NamedTypeNode):
            self._note(node.name, self._declared.datatype(node.name.text))

    # --- behaviour -------------------------------------------------------------------------------

    def _behaviour(self, node: BehaviourNode) -> None:
        for item in node.items:
            match item:
                case VariableNode():
                    self._variable(item)
                case StateNode():
                    symbol = self._declared.state_node(self._own_name, item)
                    self._note(item.name, symbol, declaration=True)
                    for transition in item.transitions:
                        self._transition(transition)
                case ResultTransitionNode() | TauNode():
                    self._transition(item)

    @property
    def _own_name(self) -> str:
        return self._own.name if self._own is not None else ""

    def _variable(self, node: VariableNode) -> None:
        self._note(node.name, self._declared.variable_node(self._own_name, node), declaration=True)
        self._type(node.type)
        if node.initial is not None:
            type_ = self._declared.type_of(node.type)
            if isinstance(node.initial, Access) and isinstance(type_, EnumType):
                self._enum_value(node.initial, type_)
            else:
                self._expression(node.initial, None)

    def _transition(self, node: ResultTransitionNode | TauNode) -> None:
        incoming: Type | None = None
        if isinstance(node, ResultTransitionNode):
            info = self._reference(node.communication)
            if info is not None and node.event in ("response", "feedback"):
                incoming = info.response if node.event == "response" else info.feedback
            for assignment in node.assignments:
                self._access(assignment.target, write=True)
                self._expression(assignment.value, incoming)
        if node.guard is not None:
            self._expression(node.guard, incoming)
        if node.goto is not None and self._own is not None:
            self._note(node.goto, self._declared.state(self._own, node.goto.text))

    # --- statements ------------------------------------------------------------------------------

    def _requirement(self, node: RequirementNode) -> None:
        for access in node.communications:
            info = self._reference(access)
            if info is not None:
                self.uses.append((info.key, node.span))
        self._expression(node.condition, None)

    def _provide(self, node: ProvideNode) -> None:
        info = self._reference(node.communication)
        self._data(node.data, info.request if info is not None else None)
        if node.condition is not None:
            self._expression(node.condition, None)

    def _data(self, node: DataNode, type_: Type | None) -> None:
        if not isinstance(node, DataObjectNode):
            self._expression(node, None)
            return
        for field_ in node.fields:
            self._field(field_, type_)

    def _field(self, node: DataFieldNode, type_: Type | None) -> None:
        inner: Type | None = None
        if isinstance(type_, ObjectType):
            self._note(node.name, self._declared.property(type_, node.name.text))
            inner = type_.property(node.name.text)
        self._data(node.value, inner)

    # --- names in expressions --------------------------------------------------------------------

    def _reference(self, access: Access) -> CommunicationInfo | None:
        """A communication; its component too where it is named."""
        member = next((p for p in access.path if isinstance(p, Name)), None)
        info = self._declared.resolve(
            access.root.text, member.text if member is not None else None, self._own
        )
        if member is None:
            self._note(access.root, self._declared.communication(info))
        else:
            self._note(access.root, self._declared.component(access.root.text))
            self._note(member, self._declared.communication(info))
        return info

    def _expression(self, node: ExprNode, incoming: Type | None) -> None:
        stack = [node]
        while stack:
            part = stack.pop()
            match part:
                case UnaryNode(operand=operand):
                    stack.append(operand)
                case BinaryNode(left=left, right=right):
                    stack += (left, right)
                case Access():
                    if is_value(part):
                        self._value(part, incoming)
                    else:
                        self._access(part)

    def _value(self, access: Access, incoming: Type | None) -> None:
        detail = str(incoming) if incoming is not None else ""
        self._note(access.root, Symbol(SymbolKind.INCOMING, "value", detail))
        type_ = incoming
        for part in access.path:
            if isinstance(part, int):
                type_ = type_.element if isinstance(type_, ArrayType) else None
            elif isinstance(type_, ObjectType):
                self._note(part, self._declared.property(type_, part.text))
                type_ = type_.property(part.text)
            else:
                return

    def _access(self, access: Access, *, write: bool = False) -> None:
        member = access.path[0] if access.path and isinstance(access.path[0], Name) else None
        last = access.root if member is None else member
        settled = self._typed.get((access.span.start, access.span.end))
        if isinstance(settled, Literal) and isinstance(settled.type, EnumType):
            self._enum_value(access, settled.type)
            return
        owner = self._declared.instances.get(access.root.text) if member is not None else self._own
        symbol = None
        if owner is not None:
            prefer_state = isinstance(settled, StateRef)
            symbol = self._declared.member(owner, last.text, prefer_state=prefer_state)
        if symbol is not None:
            self._note(last, symbol, write=write)
            if member is not None:
                self._note(access.root, self._declared.component(access.root.text))
        elif member is None:
            # As nothing else is known of the place, the first enum that has the value will do.
            for enum in self._declared.enums_with(access.root.text):
                self._enum_value(access, enum)
                break
        else:
            self._note(access.root, self._declared.component(access.root.text))
            known = self._declared.enum(access.root.text)
            if known is not None:
                self._enum_value(access, known)

    def _enum_value(self, access: Access, enum: EnumType) -> None:
        member = access.path[0] if access.path and isinstance(access.path[0], Name) else None
        last = access.root if member is None else member
        self._note(last, self._declared.value(enum, last.text))
        if member is not None:
            self._note(access.root, self._declared.datatype(access.root.text))
