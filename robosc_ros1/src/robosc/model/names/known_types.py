"""Lookup of the resolved types of a file, of its enums' values, and of constants of ROS types."""

from __future__ import annotations

from collections.abc import Iterable

from robosc.expr.tree import Literal
from robosc.expr.types import EnumType, NoneType, ObjectType, Type
from robosc.model.declarations.type_declarations import TypeDeclarations
from robosc.model.diagnostics import Report
from robosc.model.names.occurrences import Symbol, SymbolKind
from robosc.model.names.scope import FileScope
from robosc.model.names.value_scope import ValueScope
from robosc.model.ros import interfaces, missing, object_types
from robosc.model.typing.compatibility import type_of
from robosc.source import Span
from robosc.syntax.nodes import Access, EnumNode, Name, RosTypeNode


class KnownTypes:
    """The resolved types of a file by name; lookups are recorded for editors.

    ``values`` are the constants, parameters and named conditions, ``libraries`` the types of
    imported libraries by name.
    """

    def __init__(
        self, scope: FileScope, type_declarations: TypeDeclarations, report: Report
    ) -> None:
        self.scope = scope
        self.type_declarations = type_declarations
        self.values = ValueScope()
        self.libraries: dict[str, KnownTypes] = {}
        self._report = report
        self._missing = missing.MissingDefinitions(type_declarations.ros.definitions, report)
        self._types: dict[str, Type | None] = {}
        self._shells: dict[str, EnumType] = {}
        self._by_value: dict[str, list[EnumType]] = {}
        for name, node in scope.datatypes.items():
            type_declarations.nodes[scope.origin, name] = node
            if scope.is_damaged(node.span):
                type_declarations.damaged.add((scope.origin, name))
            if isinstance(node, EnumNode):
                self.add_enum(self._shell(node))

    @property
    def all_libraries(self) -> dict[str, KnownTypes]:
        """The libraries that are imported, directly or through others, by name."""
        libraries = dict(self.libraries)
        for table in self.libraries.values():
            libraries.update(table.all_libraries)
        return libraries

    def enum(self, name: str) -> EnumType | None:
        """The shell of an enum, by name."""
        return self._shells.get(name)

    def known(self, name: str) -> Type | None:
        """The resolved type of a name; None also after an error in it."""
        return self._types.get(name)

    def enums_with(self, value: str) -> Iterable[EnumType]:
        """The enums of the file that have a value of this name."""
        return self._by_value.get(value, ())

    def enum_values(self) -> Iterable[str]:
        """The names of all values of the file's enums."""
        return self._by_value

    def has_constant(self, interface: str, name: str) -> bool:
        """Whether the definition of an interface has a constant."""
        node = self.scope.interfaces[interface]
        constants = self.type_declarations.ros.constants(node.package.text, node.type.text)
        return not isinstance(constants, interfaces.Missing) and name in constants

    def interface_constant(self, access: Access, member: Name) -> Literal | None:
        """``interface.NAME``: a constant of its definition; None after an error."""
        node = self.scope.interfaces[access.root.text]
        self.scope.used_interfaces.add(access.root.text)
        self.scope.names.use(access.root, node)
        return self._ros_constant(node.package, node.type, member, access.span)

    def ros_constant(self, package: Name, type_: Name, member: Name, span: Span) -> Literal | None:
        """``package/Type.NAME``: a constant of a definition; None after an error."""
        self.scope.names.note(package, Symbol(SymbolKind.ROS_PACKAGE, package.text))
        self.scope.names.note(type_, Symbol(SymbolKind.ROS_TYPE, type_.text, package.text))
        return self._ros_constant(package, type_, member, span)

    def _ros_constant(self, package: Name, type_: Name, member: Name, span: Span) -> Literal | None:
        constants = self.type_declarations.ros.constants(package.text, type_.text)
        if isinstance(constants, interfaces.Missing):
            node = RosTypeNode(package, type_, span=span)
            self._missing.of_interface(constants, node, "message, service or action")
            return None
        name = f"{package.text}/{type_.text}"
        if member.text not in constants:
            self._report.add(
                "unknown-member",
                member.span,
                f"{name} has no constant '{member.text}'",
                self._report.suggest(member.text, constants, "its constants"),
            )
            return None
        value = constants[member.text]
        detail = f"{value!r}, a constant of {name}"
        symbol = Symbol(SymbolKind.ROS_CONSTANT, member.text, name, detail=detail)
        self.scope.names.note(member, symbol)
        return Literal(value, type_of(value), span)

    def record_property(self, name: Name, object_: ObjectType) -> None:
        """Record a name in this file as a property of an object."""
        if object_types.is_ros_type(object_):
            detail = f"field of {object_.name}"
            symbol = Symbol(SymbolKind.PROPERTY, name.text, object_.name, detail=detail)
            self.scope.names.note(name, symbol)
        elif (
            object_.property(name.text) is not None
            and (object_.origin, object_.name) in self.type_declarations.nodes
        ):
            node = self.type_declarations.property_node(object_, name.text)
            self.scope.names.use(name, node, object_.name)

    def record_value(self, access: Access, enum: EnumType) -> None:
        """Record ``value``, ``Enum.value`` or ``Library.Enum.value`` as a value of an enum."""
        *owners, value = [access.root, *(part for part in access.path if isinstance(part, Name))]
        scope = self.scope
        if len(owners) > 1:
            scope = self.libraries[owners[0].text].scope
            self.scope.names.use(owners[0], scope.node)
        if owners:
            self.scope.names.use(owners[-1], scope.datatypes.get(owners[-1].text))
        node = self.type_declarations.value_node(enum, value.text)
        self.scope.names.use(value, node, enum.name)

    def called_enum(self, function: Access) -> EnumType | None:
        """The enum, of this file or a library, that is called as a function; None otherwise."""
        match function.path:
            case ():
                enum = self._types.get(function.root.text)
                if isinstance(enum, EnumType):
                    self.scope.used_datatypes.add(enum.name)
                    self.scope.names.use(function.root, self.scope.datatypes.get(enum.name))
            case (Name(text=name),) if function.root.text in self.libraries:
                enum = self.libraries[function.root.text].known(name)
            case _:
                return None
        return enum if isinstance(enum, EnumType) else None

    def full(self, shell: EnumType) -> EnumType:
        """The enum with its rules; the shell itself if they are not resolved yet."""
        if shell.origin == self.scope.origin:
            known = self._types.get(shell.name)
            if isinstance(known, EnumType):
                return known
        return shell

    def add_enum(self, enum: EnumType) -> None:
        """Add the shell of an enum, with its values."""
        self._shells[enum.name] = enum
        for value in enum.values:
            self._by_value.setdefault(value, []).append(enum)

    def _shell(self, node: EnumNode) -> EnumType:
        """The enum without source type and rules."""
        values = tuple(dict.fromkeys(rule.value.text for rule in node.rules))
        defaults = [rule.value.text for rule in node.rules if rule.condition is None]
        default = defaults[0] if defaults else (values[0] if values else "")
        return EnumType(node.name.text, self.scope.origin, NoneType(), values, default, ())
