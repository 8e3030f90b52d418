"""The data types of one file, each resolved once, on demand.

Enums exist first as *shells* with name, values and default: expressions need no more, and the rules
of one enum can name the values of another.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping
from copy import copy
from dataclasses import replace

from robosc import limits, remedies
from robosc.expr.tree import Expr, Literal
from robosc.expr.types import (
    TYPES_BY_WORD,
    ArrayType,
    DurationType,
    EnumRule,
    EnumType,
    IntegerType,
    NoneType,
    ObjectType,
    Type,
)
from robosc.language.keywords import FOREIGN_TYPES
from robosc.lazy_dataclasses import dataclass
from robosc.model.declarations.type_declarations import TypeDeclarations, rule_of
from robosc.model.diagnostics import Report
from robosc.model.names.occurrences import Symbol, SymbolKind
from robosc.model.names.scope import FileScope, report_duplicate
from robosc.model.names.value_scope import ValueScope
from robosc.model.ros import interfaces, object_types
from robosc.model.ros.interfaces import KINDS, Interface, Missing
from robosc.model.ros.missing import MissingDefinitions
from robosc.model.typing.compatibility import type_of
from robosc.source import Span
from robosc.syntax import nodes
from robosc.syntax.nodes import Access, EnumNode, Name, RosTypeNode

# Lookup of the resolved types of a file, of its enums' values, and of constants of ROS types.


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
        self._missing = MissingDefinitions(type_declarations.ros.definitions, report)
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

    def interface_constant(
        self, interface: Name, scope: FileScope, member: Name, span: Span
    ) -> Literal | None:
        """``interface.NAME``: a constant of its definition; None after an error.

        ``scope`` is the file that declares the interface.
        """
        node = scope.interfaces[interface.text]
        scope.used_interfaces.add(interface.text)
        self.scope.names.use(interface, node)
        return self._ros_constant(node.package, node.type, member, span)

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
            case (Name(text=name) as called,) if function.root.text in self.libraries:
                library = self.libraries[function.root.text]
                enum = library.known(name)
                if isinstance(enum, EnumType):
                    self.scope.names.use(function.root, library.scope.node)
                    self.scope.names.use(called, library.scope.datatypes.get(name))
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


ConditionTyper = Callable[["TypeTable", nodes.ExprNode, Type], Expr | None]


@dataclass(frozen=True)
class Given:
    """The value of a constant or parameter that an import sets, with the import's types."""

    node: nodes.ArgumentNode
    types: TypeTable
    report: Report


class TypeTable(KnownTypes):
    """The types of a file by name; ``None`` stands for a type whose declaration has an error.

    ``condition`` types the condition of an enum's rule, given the enum's source type. ``given``
    are the values that an import sets, by name.
    """

    def __init__(
        self,
        scope: FileScope,
        type_declarations: TypeDeclarations,
        report: Report,
        condition: ConditionTyper,
    ) -> None:
        super().__init__(scope, type_declarations, report)
        self.given: Mapping[str, Given] = {}
        self._condition = condition
        self._depths: dict[str, int] = {}
        self._open: list[str] = []

    def inside(self, values: ValueScope, given: Mapping[str, Given]) -> TypeTable:
        """The same types for a component that has named values of its own."""
        table = copy(self)
        table.values = values
        table.given = given
        return table

    def reporting_to(self, report: Report) -> TypeTable:
        """The same types, with the faults in what is looked up in another report."""
        table = copy(self)
        table._report = report
        table._missing = MissingDefinitions(self.type_declarations.ros.definitions, report)
        return table

    def resolve_all(self) -> None:
        """Resolve all data types of the file, duplicates included, to report the errors in them."""
        for name in self.scope.datatypes:
            self._named(name)
        for node in self.scope.duplicates:
            if isinstance(node, nodes.ObjectNode):
                self._object(node)
            elif isinstance(node, nodes.EnumNode):
                self._enum(node)

    def resolve(self, node: nodes.TypeNode) -> Type | None:
        """The type of a node; None after a reported error."""
        match node:
            case nodes.BasicTypeNode():
                return self._basic(node)
            case nodes.ArrayTypeNode(element=element):
                inner = self.resolve(element)
                if isinstance(inner, NoneType):
                    self._report.add(
                        "none-not-allowed",
                        element.span,
                        "the elements of an array cannot be of type none",
                    )
                    return None
                return None if inner is None else ArrayType(inner)
            case nodes.RosTypeNode():
                return self._ros_type(node)
            case nodes.NamedTypeNode(library=nodes.Name() as library):
                return self._of_library(node, library)
            case nodes.NamedTypeNode(name=name):
                self.scope.names.use(name, self.scope.datatypes.get(name.text))
                if name.text not in self.scope.datatypes:
                    self._unknown(node)
                    return None
                if (
                    name.text not in self._open
                    or self._open[-1] != name.text
                    or len(self._open) > 1
                ):
                    self.scope.used_datatypes.add(name.text)
                named = self._named(name.text, node)
                return named if named is None else self._shallow(node, named)

    def of_value(self, node: nodes.TypeNode) -> Type | None:
        """The type of a constant or parameter, which may also be a duration."""
        match node:
            case nodes.NamedTypeNode(name=nodes.Name(text="duration"), library=None):
                if "duration" not in self.scope.datatypes:
                    return DurationType()
        return self.resolve(node)

    def owner(self, node: nodes.NamedTypeNode) -> KnownTypes | None:
        """The table of the file that a name is of: this one or a library; None if there is none."""
        return self if node.library is None else self.libraries.get(node.library.text)

    def _of_library(self, node: nodes.NamedTypeNode, library: nodes.Name) -> Type | None:
        """The type ``Library.Name`` of an imported library; None after a reported error."""
        table = self.libraries.get(library.text)
        if table is None:
            if library.text in self._packages_with(node.name.text):
                message = "the parts of a ROS type are joined by '/'"
                meant = remedies.write(f"{library.text}/{node.name.text}")
                self._report.add("unknown-type", node.span, message, meant)
            elif not self.scope.is_unresolved(library.text):
                self._report.add(
                    "unknown-type",
                    library.span,
                    f"nothing is imported from a library '{library.text}'",
                    self._report.suggest(library.text, self.libraries, "libraries"),
                )
            return None
        type_ = table.known(node.name.text)
        if type_ is None:
            self._report.add(
                "unknown-type",
                node.name.span,
                f"library {library.text} has no datatype '{node.name.text}'",
                self._report.suggest(node.name.text, table.scope.datatypes, "its datatypes"),
            )
            return None
        self.scope.names.use(library, table.scope.node)
        self.scope.names.use(node.name, table.scope.datatypes[node.name.text])
        return type_

    def _ros_type(self, node: nodes.RosTypeNode) -> Type | None:
        package, name = node.package, node.type
        self.scope.names.note(package, Symbol(SymbolKind.ROS_PACKAGE, package.text))
        self.scope.names.note(name, Symbol(SymbolKind.ROS_TYPE, name.text, package.text))
        kind = KINDS[node.folder]
        if node.written is not None and node.written.text != node.folder:
            self._report.add(
                "interface-not-found",
                node.written.span,
                f"this is not {'an' if kind == 'action' else 'a'} {kind}",
                f"write {package.text}/{name.text} or {package.text}/{node.folder}/{name.text}",
            )
            return None
        type_ = self.type_declarations.ros.part(package.text, name.text, node.folder, node.part)
        if isinstance(type_, Missing):
            if node.part == 0:
                self._missing.of_interface(type_, node, kind)
            return None
        definitions = self.type_declarations.ros.definitions
        interface = definitions.interface(package.text, name.text, node.folder)
        if isinstance(interface, Interface):
            self._missing.of_doubts(interface, name.span)
        for field, missing in self.type_declarations.ros.absent_in(type_):
            self._missing.of_package(missing, package.span, field=field)
        return type_

    def _shallow(self, node: nodes.NamedTypeNode, type_: Type) -> Type | None:
        """The type, or None after reporting that datatypes are nested too deep."""
        depth = self._depths.get(node.name.text, 0) + 1
        if self._open:
            self._depths[self._open[-1]] = max(depth, self._depths.get(self._open[-1], 0))
        if depth <= limits.NESTED_TYPES:
            return type_
        self._report.add(
            "too-deep",
            node.span,
            f"datatypes are nested more than {limits.NESTED_TYPES} levels deep",
        )
        return None

    def _unknown(self, node: nodes.NamedTypeNode) -> None:
        if self.scope.is_unresolved(node.name.text, "enum", "object"):
            return
        if node.name.text == "duration":
            self._report.add(
                "unknown-type",
                node.name.span,
                "only constants and parameters are durations",
                "use the type of the message: builtin_interfaces/Duration, or a double of seconds",
            )
            return
        known = [*self.scope.datatypes, *TYPES_BY_WORD]
        meant = FOREIGN_TYPES.get(node.name.text.lower().rstrip("0123456789"))
        hint: remedies.Hint | None = remedies.write(meant) if meant else None
        if hint is None and (packages := self._packages_with(node.name.text)):
            hint = remedies.write_one([f"{package}/{node.name.text}" for package in packages[:3]])
        self._report.add(
            "unknown-type",
            node.name.span,
            f"there is no datatype '{node.name.text}'",
            hint or self._report.suggest(node.name.text, known),
        )

    def _packages_with(self, name: str) -> list[str]:
        """The ROS packages that have a message, service or action of a name."""
        packages = self.type_declarations.ros.definitions.packages
        found = {p for kind in KINDS for p in packages.with_file(f"{kind}/{name}.{kind}")}
        return sorted(found)

    def _basic(self, node: nodes.BasicTypeNode) -> Type | None:
        if node.bounds is None:
            return TYPES_BY_WORD[node.name]
        if node.bounds[0] > node.bounds[1]:
            low, high = node.bounds
            meant = f"{node.name}({high}..{low})"
            self._report.add(
                "empty-range",
                node.span,
                f"no {node.name} is at least {low} and at most {high}",
                remedies.Remedy(f"write {meant}", remedies.Change.REPLACE, (meant,)),
            )
            return None
        low, high = node.bounds
        if node.name == "integer":
            return IntegerType((int(low), int(high)))
        return TYPES_BY_WORD[node.name]

    def called_enum(self, function: nodes.Access) -> EnumType | None:
        """The enum that is called as a function, which may be declared further down."""
        name = function.root.text
        declared = not function.path and isinstance(self.scope.datatypes.get(name), nodes.EnumNode)
        if declared and name not in self._open:
            self._named(name)
        return super().called_enum(function)

    def _named(self, name: str, use: nodes.NamedTypeNode | None = None) -> Type | None:
        if name in self._types:
            return self._types[name]
        if name in self._open:
            cycle = [*self._open[self._open.index(name) :], name]
            assert use is not None
            self._report.add(
                "recursive-datatype",
                use.span,
                f"{name} would contain itself: {' -> '.join(cycle)}",
                "no ROS message can contain itself",
            )
            return None
        if len(self._open) > limits.NESTED_TYPES:
            return self._shallow(use, NoneType()) if use is not None else None
        self._open.append(name)
        node = self.scope.datatypes[name]
        type_ = self._object(node) if isinstance(node, nodes.ObjectNode) else self._enum(node)
        self._open.pop()
        self._types[name] = type_
        return type_

    def _object(self, node: nodes.ObjectNode) -> ObjectType:
        seen: dict[str, Span] = {}
        properties: list[tuple[str, Type]] = []
        for prop in node.properties:
            name = prop.name.text
            self.scope.names.declare(prop, node.name.text)
            if name in seen:
                report_duplicate("property", prop.name, seen[name], self._report)
                continue
            seen[name] = prop.name.span
            type_ = self.resolve(prop.type)
            if isinstance(type_, NoneType):
                self._report.add(
                    "none-not-allowed",
                    prop.type.span,
                    f"property '{name}' cannot be of type none",
                    "leave the property out",
                )
                type_ = None
            if type_ is None:
                self.type_declarations.unknown_properties.add(
                    (self.scope.origin, node.name.text, name)
                )
            else:
                properties.append((name, type_))
        return ObjectType(node.name.text, self.scope.origin, tuple(properties))

    def _enum(self, node: nodes.EnumNode) -> EnumType:
        """The enum without its faulty rules; only the shell if its source type is faulty."""
        source = self.resolve(node.source)
        self._check_source(node, source)
        self._check_values(node)
        shell = self._shell(node)
        if source is None or isinstance(source, EnumType | NoneType):
            self.type_declarations.unknown_sources.add((shell.origin, shell.name))
            return shell
        rules = []
        for rule in node.rules:
            if rule.condition is not None:
                condition = self._condition(self, rule.condition, source)
                if condition is not None:
                    rules.append(EnumRule(condition, rule.value.text))
        return replace(shell, source=source, rules=tuple(rules))

    def _check_source(self, node: nodes.EnumNode, source: Type | None) -> None:
        if isinstance(source, EnumType):
            self._report.add(
                "enum-source",
                node.source.span,
                f"{node.name.text} cannot convert from the enum {source.name}",
                f"convert from what {source.name} converts: {source.source}",
            )
        elif isinstance(source, NoneType):
            self._report.add(
                "enum-source",
                node.source.span,
                f"{node.name.text} cannot convert from none, which carries nothing",
            )

    def _record_value(self, node: nodes.EnumNode, rule: nodes.EnumRuleNode) -> None:
        first = rule_of(node, rule.value.text)
        if first is rule:
            self.scope.names.declare(rule, node.name.text)
        else:
            self.scope.names.use(rule.value, first, node.name.text)

    def _check_values(self, node: nodes.EnumNode) -> None:
        default: Span | None = None
        for rule in node.rules:
            self._record_value(node, rule)
            if rule.condition is None:
                if default is not None:
                    self._report.add(
                        "several-defaults",
                        rule.span,
                        f"{node.name.text} already has a default",
                        remedies.Remedy("remove one of them", remedies.Change.REMOVE),
                    )
                default = rule.span
        if default is None and not self.scope.is_damaged(node.span):
            rule_ = f"default -> {node.rules[-1].value.text if node.rules else 'other'}"
            self._report.add(
                "missing-default",
                node.name.span,
                f"{node.name.text} has no value for data that no rule matches",
                remedies.Remedy(f"add: {rule_}", remedies.Change.ADD_DEFAULT, (rule_,)),
            )
