"""Symbols of what a file declares or imports, looked up by what refers to them."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from functools import cached_property

from robosc.lsp.symbols import Symbol, SymbolKind
from robosc.model.resolve import ResolvedFile
from robosc.model.rosmsg import BASIC, Definition, Interface, MessageDefinitions
from robosc.model.tables import CommunicationInfo, Instance, SymbolTable
from robosc.model.types import (
    ArrayType,
    BooleanType,
    DoubleType,
    EnumType,
    IntegerType,
    NoneType,
    ObjectType,
    StringType,
    Type,
)
from robosc.syntax.nodes import (
    ActionNode,
    ArrayTypeNode,
    BasicTypeNode,
    CommunicationNode,
    ComponentNode,
    EnumNode,
    ImportNode,
    MessageNode,
    NamedTypeNode,
    ObjectNode,
    PropertyNode,
    ServiceNode,
    StateNode,
    TypeNode,
    VariableNode,
)

__all__ = ["Declared"]

_BASIC: Mapping[str, Type] = {
    "string": StringType(),
    "boolean": BooleanType(),
    "double": DoubleType(),
    "none": NoneType(),
}


class Declared:
    """The tables of a resolved file, asked in terms of symbols. None: there is no such thing."""

    def __init__(self, file: ResolvedFile, definitions: MessageDefinitions) -> None:
        assert (
            file.scope is not None and file.types is not None and file.component_table is not None
        )
        self.scope = file.scope
        self.types = file.types
        self.component_table = file.component_table
        self.definitions = definitions

    @property
    def instances(self) -> Mapping[str, Instance]:
        return self.component_table.instances

    def instance(self, node: ComponentNode) -> Instance | None:
        """The component of a declaration, unless its name was taken."""
        found = self.instances.get(node.name.text)
        return found if found is not None and found.node is node else None

    # --- components ------------------------------------------------------------------------------

    def component(self, name: str) -> Symbol | None:
        node = self.scope.components.get(name)
        if isinstance(node, ImportNode):
            return self.import_node(node)
        return self.component_node(node) if node is not None else None

    def component_node(self, node: ComponentNode) -> Symbol:
        name = node.name
        return Symbol(SymbolKind.COMPONENT, name.text, "", name.span, node.span, "component")

    def import_node(self, node: ImportNode) -> Symbol:
        detail = f"component {node.component.text} of library {node.library.text}"
        return Symbol(SymbolKind.COMPONENT, node.name.text, "", node.name.span, node.span, detail)

    def library(self, node: ImportNode) -> Symbol | None:
        instance = self.instances.get(node.name.text)
        if instance is None or instance.imported is None:
            return None
        scope = instance.types.scope
        if scope.node.name.text != node.library.text and instance.original is not None:
            scope = instance.original.types.scope
        file = scope.node
        if file.name.text != node.library.text:
            return None  # the library itself imports the component from another one
        return Symbol(SymbolKind.LIBRARY, file.name.text, "", file.name.span, None, "library")

    def imported(self, node: ImportNode) -> Symbol | None:
        instance = self.instances.get(node.name.text)
        if instance is None or instance.original is None:
            return None
        original = instance.original
        if original.imported is not None:
            return self.import_node(original.imported)
        return self.component_node(original.node)

    # --- members of components -------------------------------------------------------------------

    def member(self, owner: Instance, name: str, *, prefer_state: bool) -> Symbol | None:
        """A variable or state."""
        first, second = self.variable(owner, name), self.state(owner, name)
        if prefer_state:
            first, second = second, first
        return first if first is not None else second

    def state(self, owner: Instance, name: str) -> Symbol | None:
        node = owner.states.get(name)
        return self.state_node(owner.name, node) if node is not None else None

    def state_node(self, owner: str, node: StateNode) -> Symbol:
        words = ["initial"] * node.initial + ["marked"] * node.marked + ["state"]
        return Symbol(
            SymbolKind.STATE, node.name.text, owner, node.name.span, node.span, " ".join(words)
        )

    def variable(self, owner: Instance, name: str) -> Symbol | None:
        node = owner.variable_nodes.get(name)
        return self.variable_node(owner.name, node) if node is not None else None

    def variable_node(self, owner: str, node: VariableNode) -> Symbol:
        detail = f"variable: {node.type.span.text}"
        return Symbol(SymbolKind.VARIABLE, node.name.text, owner, node.name.span, node.span, detail)

    # --- communications --------------------------------------------------------------------------

    def resolve(
        self, root: str, member: str | None, own: Instance | None
    ) -> CommunicationInfo | None:
        """The communication of a bare or qualified name."""
        if member is not None:
            owner = self.instances.get(root)
            return owner.communications.get(member) if owner is not None else None
        found = SymbolTable(self.component_table, own).communications(root)
        return found[0] if found else None

    def communication(self, info: CommunicationInfo | None) -> Symbol | None:
        if info is None:
            return None
        return self.communication_node(info.instance.name, info.node)

    def communication_node(self, owner: str, node: CommunicationNode) -> Symbol:
        match node:
            case MessageNode():
                detail = f"{node.direction} message: {node.type.span.text}"
            case ServiceNode():
                detail = f"service: {node.request.span.text} → {node.response.span.text}"
            case ActionNode():
                detail = f"action: {node.request.span.text} → {node.response.span.text}"
        return Symbol(
            SymbolKind.COMMUNICATION, node.name.text, owner, node.name.span, node.span, detail
        )

    # --- data types and interfaces ---------------------------------------------------------------

    def interface(self, name: str) -> Symbol | None:
        node = self.scope.interfaces.get(name)
        if node is None:
            return None
        detail = f"interface: {node.package.text}/{node.type.text}"
        return Symbol(SymbolKind.INTERFACE, name, "", node.name.span, node.span, detail)

    def datatype(self, name: str) -> Symbol | None:
        node = self.scope.datatypes.get(name)
        return self.datatype_node(node) if node is not None else None

    def datatype_node(self, node: ObjectNode | EnumNode) -> Symbol:
        kind, detail = SymbolKind.OBJECT, "datatype object"
        if isinstance(node, EnumNode):
            kind, detail = SymbolKind.ENUM, f"datatype enum from {node.source.span.text}"
        return Symbol(kind, node.name.text, "", node.name.span, node.span, detail)

    def property_node(self, owner: str, node: PropertyNode) -> Symbol:
        detail = f"property: {node.type.span.text}"
        return Symbol(SymbolKind.PROPERTY, node.name.text, owner, node.name.span, node.span, detail)

    def property(self, type_: ObjectType, name: str) -> Symbol | None:
        node = self.types.type_declarations.nodes.get((type_.origin, type_.name))
        if not isinstance(node, ObjectNode):
            return None
        found = next((p for p in node.properties if p.name.text == name), None)
        return self.property_node(type_.name, found) if found is not None else None

    def value(self, enum: EnumType, name: str) -> Symbol | None:
        node = self.types.type_declarations.nodes.get((enum.origin, enum.name))
        return self.value_of(node, name) if isinstance(node, EnumNode) else None

    def value_of(self, node: EnumNode, name: str) -> Symbol | None:
        """A value is declared by the first rule that gives it."""
        rule = next((r for r in node.rules if r.value.text == name), None)
        if rule is None:
            return None
        owner = node.name.text
        return Symbol(
            SymbolKind.VALUE, name, owner, rule.value.span, rule.span, f"value of {owner}"
        )

    def enum(self, name: str) -> EnumType | None:
        return self.types.enum(name)

    def enums_with(self, value: str) -> Iterable[EnumType]:
        return self.types.enums_with(value)

    def type_of(self, node: TypeNode) -> Type | None:
        """What a type means, as far as it is known."""
        match node:
            case NamedTypeNode(name=name):
                return self.types.known(name.text)
            case ArrayTypeNode(element=element):
                inner = self.type_of(element)
                return ArrayType(inner) if inner is not None else None
            case BasicTypeNode(name="integer", bounds=bounds):
                return IntegerType(bounds)
            case BasicTypeNode(name=basic):
                return _BASIC[basic]

    # --- message definitions ---------------------------------------------------------------------

    def interface_of(self, info: CommunicationInfo) -> Interface | None:
        """The real definition that carries a communication."""
        links = info.node.links
        if links is None:
            binding = info.entity.binding if info.entity is not None else None
            return next((i for i in BASIC.values() if binding and i.type == binding.type), None)
        interface = info.instance.types.scope.interfaces.get(links.text)
        if interface is None:
            return None
        package, type_ = interface.package.text, interface.type.text
        match info.node:
            case MessageNode():
                found = self.definitions.message(package, type_)
            case ServiceNode():
                found = self.definitions.service(package, type_)
            case ActionNode():
                found = self.definitions.action(package, type_)
        return found if isinstance(found, Interface) else None

    @cached_property
    def carriers(self) -> Mapping[str, Definition]:
        """The definition behind each object datatype of this file, where one carries it."""
        found: dict[str, Definition] = {}
        for instance in self.instances.values():
            for info in instance.communications.values():
                interface = self.interface_of(info)
                if interface is None or info.instance.types.scope is not self.scope:
                    continue
                for node, part in zip(_parts(info.node), interface.parts, strict=False):
                    self._carry(self.type_of(node), part, found)
        return found

    def _carry(self, type_: Type | None, part: Definition, found: dict[str, Definition]) -> None:
        while isinstance(type_, ArrayType | EnumType):
            type_ = type_.element if isinstance(type_, ArrayType) else type_.source
        if not isinstance(type_, ObjectType) or type_.name in found:
            return
        found[type_.name] = part
        for name, inner in type_.properties:
            field = part.field(name)
            nested = self.definitions.fields(field.type.element) if field is not None else None
            if isinstance(nested, Definition):
                self._carry(inner, nested, found)


def _parts(node: CommunicationNode) -> tuple[TypeNode, ...]:
    match node:
        case MessageNode():
            return (node.type,)
        case ServiceNode():
            return (node.request, node.response)
        case ActionNode():
            return (node.request, node.response, node.feedback)
