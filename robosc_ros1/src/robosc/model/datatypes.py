"""The data types of one file, resolved on demand and once.

Enums exist first as *shells* that know name, values and default: that is all that expressions need,
and it lets the rules of one enum name the values of another.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable
from copy import copy
from dataclasses import dataclass, field, replace

from robosc.errors import Diagnostic
from robosc.language.keywords import BASIC_TYPES
from robosc.model.expr import Expr, Literal
from robosc.model.occurrences import Symbol, SymbolKind
from robosc.model.report import Report
from robosc.model.ros.definitions import MessageDefinitions, Missing
from robosc.model.ros.missing import KINDS, MissingDefinitions
from robosc.model.ros.types import RosTypes, is_ros_type
from robosc.model.scope import FileScope, report_duplicate
from robosc.model.types import (
    ArrayType,
    BooleanType,
    DoubleType,
    DurationType,
    EnumRule,
    EnumType,
    IntegerType,
    NoneType,
    ObjectType,
    StringType,
    Type,
)
from robosc.model.value_scope import ValueScope
from robosc.model.values import type_of
from robosc.source import Span
from robosc.syntax.nodes import (
    Access,
    ArrayTypeNode,
    BasicTypeNode,
    EnumNode,
    EnumRuleNode,
    ExprNode,
    Name,
    NamedTypeNode,
    ObjectNode,
    PropertyNode,
    RosTypeNode,
    TypeNode,
)

__all__ = ["TypeTable", "TypeDeclarations"]


@dataclass
class TypeDeclarations:
    """What all files of one run share: declarations by (origin, name), and what is unknown in them.

    ``unknown_properties`` are properties whose type has an error, ``unknown_sources`` enums that
    convert from such a type, ``damaged`` the declarations of which a part did not parse; ``missed``
    are the reports of properties that an object was expected to have; ``ros`` are the types that
    ROS itself defines.
    """

    nodes: dict[tuple[str, str], ObjectNode | EnumNode] = field(default_factory=dict)
    unknown_properties: set[tuple[str, str, str]] = field(default_factory=set)
    damaged: set[tuple[str, str]] = field(default_factory=set)
    unknown_sources: set[tuple[str, str]] = field(default_factory=set)
    missed: dict[tuple[str, str, str], list[Diagnostic]] = field(default_factory=dict)
    ros: RosTypes = field(default_factory=lambda: RosTypes(MessageDefinitions()))

    def property_node(self, object_: ObjectType, name: str) -> PropertyNode:
        """The declaration of an object's property."""
        node = self.nodes[object_.origin, object_.name]
        assert isinstance(node, ObjectNode)
        return next(p for p in node.properties if p.name.text == name)

    def may_have(self, type_: ObjectType | EnumType, name: str) -> bool:
        """Whether a property or value that is not known may be one all the same."""
        key = (type_.origin, type_.name)
        return key in self.damaged or (*key, name) in self.unknown_properties

    def miss(self, type_: ObjectType, name: str, told: Diagnostic) -> None:
        """Note that it was reported that an object has no such property."""
        self.missed.setdefault((type_.origin, type_.name, name), []).append(told)

    def is_misread(self, type_: ObjectType, name: str) -> bool:
        """Whether a property may be the type of one whose name is missing."""
        origin = type_.origin
        is_type = name in BASIC_TYPES or (origin, name) in self.nodes
        return is_type and (origin, type_.name) in self.damaged

    def value_node(self, enum: EnumType, value: str) -> EnumRuleNode | None:
        """The rule that declares an enum's value: the first one that gives it."""
        node = self.nodes.get((enum.origin, enum.name))
        return rule_of(node, value) if isinstance(node, EnumNode) else None

    def is_known(self, type_: Type) -> bool:
        """Whether what a type carries is known: an enum's source may not be."""
        return (
            not isinstance(type_, EnumType)
            or (type_.origin, type_.name) not in self.unknown_sources
        )


def rule_of(node: EnumNode, value: str) -> EnumRuleNode | None:
    """The first rule that gives a value."""
    return next((rule for rule in node.rules if rule.value.text == value), None)


# Far beyond any ROS message; keeps whatever walks through types from exhausting the stack.
_DEEPEST = 50

# What ROS and other languages call the built-in types, without the number of bits.
_FOREIGN = {
    "float": "double",
    "real": "double",
    "int": "integer",
    "uint": "integer",
    "bool": "boolean",
    "str": "string",
    "empty": "none",
    "void": "none",
}

ConditionTyper = Callable[["TypeTable", ExprNode, Type], Expr | None]


class TypeTable:
    """Types by name; ``None`` stands for a type whose declaration has an error.

    ``condition`` types the condition of an enum rule over the incoming value's type. ``values``
    are the constants and named conditions, ``libraries`` the types of those that are imported.
    """

    def __init__(
        self,
        scope: FileScope,
        type_declarations: TypeDeclarations,
        report: Report,
        condition: ConditionTyper,
    ) -> None:
        self.scope = scope
        self.type_declarations = type_declarations
        self.values = ValueScope()
        self.libraries: dict[str, TypeTable] = {}
        self._report = report
        self._condition = condition
        self._missing = MissingDefinitions(type_declarations.ros.definitions, report)
        self._types: dict[str, Type | None] = {}
        self._depths: dict[str, int] = {}
        self._open: list[str] = []
        self._shells: dict[str, EnumType] = {}
        self._by_value: dict[str, list[EnumType]] = {}
        for name, node in scope.datatypes.items():
            type_declarations.nodes[scope.origin, name] = node
            if scope.is_damaged(node.span):
                type_declarations.damaged.add((scope.origin, name))
            if isinstance(node, EnumNode):
                self.add_enum(self._shell(node))

    def inside(self, values: ValueScope) -> TypeTable:
        """The same types as a component sees them, which names values of its own."""
        table = copy(self)
        table.values = values
        return table

    @property
    def all_libraries(self) -> dict[str, TypeTable]:
        """The imported libraries, and those that they import, by name."""
        found = dict(self.libraries)
        for table in self.libraries.values():
            found.update(table.all_libraries)
        return found

    def resolve_all(self) -> None:
        for name in self.scope.datatypes:
            self._named(name)
        for node in self.scope.duplicates:
            if isinstance(node, ObjectNode):
                self._object(node)
            elif isinstance(node, EnumNode):
                self._enum(node)

    def enum(self, name: str) -> EnumType | None:
        """The enum as expressions know it."""
        return self._shells.get(name)

    def known(self, name: str) -> Type | None:
        """A type that has been resolved, by name."""
        return self._types.get(name)

    def enums_with(self, value: str) -> Iterable[EnumType]:
        return self._by_value.get(value, ())

    def enum_values(self) -> Iterable[str]:
        return self._by_value

    def has_constant(self, interface: str, name: str) -> bool:
        """Whether the definition of an interface has a constant."""
        node = self.scope.interfaces[interface]
        found = self.type_declarations.ros.constants(node.package.text, node.type.text)
        return not isinstance(found, Missing) and name in found

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
        found = self.type_declarations.ros.constants(package.text, type_.text)
        if isinstance(found, Missing):
            node = RosTypeNode(package, type_, span=span)
            self._missing.of_interface(found, node, "message, service or action")
            return None
        name = f"{package.text}/{type_.text}"
        if member.text not in found:
            self._report.add(
                "unknown-member",
                member.span,
                f"{name} has no constant '{member.text}'",
                self._report.suggest(member.text, found, "its constants"),
            )
            return None
        value = found[member.text]
        detail = f"{value!r}, a constant of {name}"
        symbol = Symbol(SymbolKind.ROS_CONSTANT, member.text, name, detail=detail)
        self.scope.names.note(member, symbol)
        return Literal(value, type_of(value), span)

    def record_property(self, name: Name, object_: ObjectType) -> None:
        """Note that a name in this file is a property of an object."""
        if is_ros_type(object_):
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
        """Note that ``value`` or ``Enum.value`` in this file is a value of an enum."""
        value = access.root
        if access.path and isinstance(access.path[0], Name):
            value = access.path[0]
            self.scope.names.use(access.root, self.scope.datatypes.get(access.root.text))
        node = self.type_declarations.value_node(enum, value.text)
        self.scope.names.use(value, node, enum.name)

    def called_enum(self, function: Access) -> EnumType | None:
        """The enum that is used as a function, of this file or of a library."""
        match function.path:
            case ():
                found = self._types.get(function.root.text)
                if isinstance(found, EnumType):
                    self.scope.used_datatypes.add(found.name)
                    self.scope.names.use(function.root, self.scope.datatypes.get(found.name))
            case (Name(text=name),) if function.root.text in self.libraries:
                found = self.libraries[function.root.text].known(name)
            case _:
                return None
        return found if isinstance(found, EnumType) else None

    def full(self, shell: EnumType) -> EnumType:
        """The enum with its rules, where they are known already."""
        if shell.origin == self.scope.origin:
            known = self._types.get(shell.name)
            if isinstance(known, EnumType):
                return known
        return shell

    def resolve(self, node: TypeNode) -> Type | None:
        """The type that a node means, or None after an error that has been reported."""
        match node:
            case BasicTypeNode():
                return self._basic(node)
            case ArrayTypeNode(element=element):
                inner = self.resolve(element)
                if isinstance(inner, NoneType):
                    self._report.add(
                        "none-not-allowed", element.span, "an array cannot consist of none"
                    )
                    return None
                return None if inner is None else ArrayType(inner)
            case RosTypeNode():
                return self._ros_type(node)
            case NamedTypeNode(library=Name() as library):
                return self._of_library(node, library)
            case NamedTypeNode(name=name):
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
                found = self._named(name.text, node)
                return found if found is None else self._shallow(node, found)

    def of_value(self, node: TypeNode) -> Type | None:
        """The type of a constant or parameter, which may be a duration."""
        match node:
            case NamedTypeNode(name=Name(text="duration"), library=None):
                if "duration" not in self.scope.datatypes:
                    return DurationType()
        return self.resolve(node)

    def _of_library(self, node: NamedTypeNode, library: Name) -> Type | None:
        """The type ``Library.Name`` of a library from which something is imported."""
        table = self.libraries.get(library.text)
        if table is None:
            if not self.scope.is_unresolved(library.text):
                self._report.add(
                    "unknown-type",
                    library.span,
                    f"nothing is imported from a library '{library.text}'",
                    self._report.suggest(library.text, self.libraries, "libraries"),
                )
            return None
        found = table.known(node.name.text)
        if found is None:
            self._report.add(
                "unknown-type",
                node.name.span,
                f"library {library.text} has no datatype '{node.name.text}'",
                self._report.suggest(node.name.text, table.scope.datatypes, "its datatypes"),
            )
            return None
        self.scope.names.use(library, table.scope.node)
        self.scope.names.use(node.name, table.scope.datatypes[node.name.text])
        return found

    def _ros_type(self, node: RosTypeNode) -> Type | None:
        package, name = node.package, node.type
        self.scope.names.note(package, Symbol(SymbolKind.ROS_PACKAGE, package.text))
        self.scope.names.note(name, Symbol(SymbolKind.ROS_TYPE, name.text, package.text))
        kind = KINDS[node.folder]
        if node.written is not None and node.written.text != node.folder:
            self._report.add(
                "interface-not-found",
                node.written.span,
                f"this is no {kind}",
                f"write {package.text}/{name.text} or {package.text}/{node.folder}/{name.text}",
            )
            return None
        found = self.type_declarations.ros.part(package.text, name.text, node.folder, node.part)
        if isinstance(found, Missing):
            if node.part == 0:
                self._missing.of_interface(found, node, kind)
            return None
        return found

    def _shallow(self, node: NamedTypeNode, found: Type) -> Type | None:
        """The type, unless datatypes are nested deeper than anything that ROS carries."""
        depth = self._depths.get(node.name.text, 0) + 1
        if self._open:
            self._depths[self._open[-1]] = max(depth, self._depths.get(self._open[-1], 0))
        if depth <= _DEEPEST:
            return found
        self._report.add(
            "too-deep", node.span, f"datatypes are nested more than {_DEEPEST} levels deep"
        )
        return None

    def _unknown(self, node: NamedTypeNode) -> None:
        if self.scope.is_unresolved(node.name.text, "enum", "object"):
            return
        if node.name.text == "duration":
            self._report.add(
                "unknown-type",
                node.name.span,
                "only constants and parameters are durations",
                "name what the message has: builtin_interfaces/Duration, or a double of seconds",
            )
            return
        basic = ("string", "boolean", "double", "integer", "none")
        meant = _FOREIGN.get(node.name.text.lower().rstrip("0123456789"))
        self._report.add(
            "unknown-type",
            node.name.span,
            f"there is no datatype '{node.name.text}'",
            f"write '{meant}'"
            if meant
            else self._report.suggest(node.name.text, [*self.scope.datatypes, *basic]),
        )

    def _basic(self, node: BasicTypeNode) -> Type | None:
        match node.name:
            case "string":
                return StringType()
            case "boolean":
                return BooleanType()
            case "double":
                return DoubleType()
            case "none":
                return NoneType()
        if node.bounds is not None and node.bounds[0] > node.bounds[1]:
            low, high = node.bounds
            self._report.add(
                "empty-range",
                node.span,
                f"no integer is at least {low} and at most {high}",
                f"write integer({high}..{low})",
            )
            return None
        return IntegerType(node.bounds)

    def _named(self, name: str, use: NamedTypeNode | None = None) -> Type | None:
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
        if len(self._open) > _DEEPEST:
            return self._shallow(use, NoneType()) if use is not None else None
        self._open.append(name)
        node = self.scope.datatypes[name]
        found = self._object(node) if isinstance(node, ObjectNode) else self._enum(node)
        self._open.pop()
        self._types[name] = found
        return found

    def _object(self, node: ObjectNode) -> ObjectType:
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

    def add_enum(self, enum: EnumType) -> None:
        """Let expressions know an enum and its values."""
        self._shells[enum.name] = enum
        for value in enum.values:
            self._by_value.setdefault(value, []).append(enum)

    def _shell(self, node: EnumNode) -> EnumType:
        """The enum by its values, without rules."""
        values = tuple(dict.fromkeys(rule.value.text for rule in node.rules))
        defaults = [rule.value.text for rule in node.rules if rule.condition is None]
        default = defaults[0] if defaults else (values[0] if values else "")
        return EnumType(node.name.text, self.scope.origin, NoneType(), values, default, ())

    def _enum(self, node: EnumNode) -> EnumType:
        """The enum. With an error it is still known by its values, without the faulty rules."""
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

    def _check_source(self, node: EnumNode, source: Type | None) -> None:
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
                f"{node.name.text} has nothing to convert from none",
            )

    def _record_value(self, node: EnumNode, rule: EnumRuleNode) -> None:
        first = rule_of(node, rule.value.text)
        if first is rule:
            self.scope.names.declare(rule, node.name.text)
        else:
            self.scope.names.use(rule.value, first, node.name.text)

    def _check_values(self, node: EnumNode) -> None:
        default: Span | None = None
        for rule in node.rules:
            self._record_value(node, rule)
            if rule.condition is None:
                if default is not None:
                    self._report.add(
                        "several-defaults",
                        rule.span,
                        f"{node.name.text} has a default already",
                        "remove one of them",
                    )
                default = rule.span
        if default is None and not self.scope.is_damaged(node.span):
            value = node.rules[-1].value.text if node.rules else "other"
            self._report.add(
                "missing-default",
                node.name.span,
                f"{node.name.text} does not say what a value becomes that no rule matches",
                f"add: default -> {value}",
            )
