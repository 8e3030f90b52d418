"""Binding of communications to ROS interfaces, and the check of types against definitions.

Values that are sent must fit the field (no double for an integer field, no wider range); values
that are received must fit the model's type (an integer field as a double, but not the reverse).
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import replace
from math import inf
from typing import Any

from robosc import remedies
from robosc.expr.types import ArrayType, EnumType, IntegerType, NoneType, ObjectType, Type
from robosc.language.events import COMMUNICATIONS, Direction
from robosc.lazy_dataclasses import dataclass
from robosc.model.checks.used_fields import Path, Usage
from robosc.model.declarations.type_declarations import TypeDeclarations
from robosc.model.diagnostics import Report, first_of
from robosc.model.entities import Binding
from robosc.model.names.occurrences import kind_of
from robosc.model.ros import object_types, sent
from robosc.model.ros.definitions import BASIC, MessageDefinitions
from robosc.model.ros.interfaces import KINDS, Definition, FieldType, Interface, Missing
from robosc.model.ros.missing import MissingDefinitions
from robosc.runtime.core.heavy import LIGHT
from robosc.source import Span
from robosc.syntax import nodes

_HEADER = FieldType("std_msgs/Header")


@dataclass(frozen=True)
class Payload:
    """One direction of a communication: its type in the model, and the node of the type.

    ``sending``: the controller gives these data.
    """

    type: Type
    node: nodes.TypeNode
    direction: Direction
    sending: bool


@dataclass(frozen=True)
class _Unknown:
    """A property, at ``path`` of a message, without a field in the message's definition."""

    object: ObjectType
    path: Path
    property: nodes.Name
    definition: Definition


class Binder:
    """Binds the communications of one file; reports each missing package once."""

    def __init__(
        self, definitions: MessageDefinitions, type_declarations: TypeDeclarations, report: Report
    ) -> None:
        self._definitions = definitions
        self._type_declarations = type_declarations
        self._report = report
        self.missing = MissingDefinitions(definitions, report)
        self.sent = sent.SentData(definitions, report)
        self._looked_up: set[nodes.InterfaceNode | nodes.RosTypeNode] = set()
        self._checked: dict[tuple[ObjectType, str, bool], list[_Unknown]] = {}
        self._unknown: list[tuple[str, Direction, _Unknown]] = []
        self.lengths: dict[tuple[ObjectType, str], tuple[int, str]] = {}
        """Array properties of fixed length: the least number of elements, and the field."""

    def bind(
        self,
        key: str,
        node: nodes.CommunicationNode,
        parts: tuple[Payload, ...],
        interface: nodes.InterfaceNode | nodes.RosTypeNode | None,
    ) -> Binding | None:
        """The binding of the communication with a key; None after a reported error.

        ``interface`` is the linked interface or ROS type; None if the model names none.
        """
        if interface is None:
            return self._default(key, node, parts)
        package, type_ = interface.package.text, interface.type.text
        self._looked_up.add(interface)
        folder = COMMUNICATIONS[kind_of(node)].folder
        found = self._definitions.interface(package, type_, folder)
        if isinstance(found, Missing):
            kind = KINDS[folder]
            if not self.missing.of_interface(found, interface, kind):
                return None
            # Without the definition, take the file name as ROS derives it from the type.
            stem = type_.removesuffix("Action") if isinstance(node, nodes.ActionNode) else type_
            return Binding(package, stem or type_, False)
        self.missing.of_doubts(found, interface.type.span)
        pairs = zip(parts, found.parts, strict=True)
        return self._binding(found, parts, [self._check_part(key, *pair) for pair in pairs])

    def _default(
        self, key: str, node: nodes.CommunicationNode, parts: tuple[Payload, ...]
    ) -> Binding | None:
        """The binding of a communication without interface: for messages of basic types only."""
        links = "links NAME, and declare: interface NAME use TYPE from PACKAGE"
        if not isinstance(node, nodes.MessageNode):
            what = "service" if isinstance(node, nodes.ServiceNode) else "action"
            self._report.add(
                "missing-links",
                node.name.span,
                f"{what} '{node.name.text}' does not say which ROS {what} it is",
                remedies.Remedy(f"add: {links}", remedies.Change.LINK, ("NAME",)),
            )
            return None
        (part,) = parts
        carried = part.type.source if isinstance(part.type, EnumType) else part.type
        if isinstance(carried, ObjectType) and object_types.is_ros_type(carried):
            package, _, name = carried.name.partition("/")
            found = self._definitions.interface(package, name, "msg")
            light = isinstance(found, Interface) and self._is_light(found)
            return Binding(package, name, True, light=light)
        interface = BASIC.get(_basic_name(carried))
        if interface is None:
            self._report.add(
                "missing-links",
                node.type.span,
                f"message '{node.name.text}' does not say which ROS message carries {carried}",
                self._links_hint(carried),
            )
            return None
        field = self._check_part(key, part, interface.parts[0])
        return self._binding(interface, parts, [field])

    def _links_hint(self, carried: Type) -> remedies.Remedy:
        name = carried.name if isinstance(carried, ObjectType) else "TYPE"
        packages = self._definitions.packages.with_file(f"msg/{name}.msg")
        package = packages[0] if packages else "PACKAGE"
        alias = name.lower() if name != "TYPE" else "NAME"
        declaration = f"interface {alias} use {name} from {package}"
        known = (declaration,) if packages else ()
        text = f"add: links {alias}\nand declare: {declaration}"
        return remedies.Remedy(text, remedies.Change.LINK, (alias, *known))

    def check_unlinked(self, interfaces: Iterable[nodes.InterfaceNode]) -> None:
        """Report interfaces that no communication links and that no definition has."""
        for interface in interfaces:
            if interface in self._looked_up or not is_legal(interface):
                continue
            package, type_ = interface.package.text, interface.type.text
            found = [self._definitions.interface(package, type_, folder) for folder in KINDS]
            missing = [f for f in found if isinstance(f, Missing) and f.reason == "file"]
            if len(missing) == len(found):
                names = [name for one in missing for name in one.names]
                self._report.add(
                    "interface-not-found",
                    interface.type.span,
                    f"{package} has no message, service or action '{type_}'",
                    self._report.suggest(type_, names, "it has"),
                )

    def check_header(self, message: Binding, max_age: Span) -> None:
        """Report a message whose age is asked for, but whose definition has no header."""
        found = self._definitions.interface(message.package, message.type, "msg")
        if isinstance(found, Missing):
            has_header = not message.found  # else it is a built-in one of std_msgs
        else:
            header = found.parts[0].field("header")
            has_header = header is not None and header.type == _HEADER
        if not has_header:
            self._report.add(
                "unknown-field",
                max_age,
                f"{message.package}/{message.type} has no header, by whose stamp its age is known",
                "leave 'max_age:' out, or use a message with a header: std_msgs/Header header",
            )

    # --- types against definitions ---------------------------------------------------------------

    def _check_part(self, key: str, part: Payload, definition: Definition) -> str | None:
        """Check one direction; the name of the only data field, if that carries the type."""
        carried = part.type.source if isinstance(part.type, EnumType) else part.type
        if isinstance(carried, NoneType):
            return None
        if isinstance(carried, ObjectType):
            for unknown in self._check_object(carried, definition, part.sending, part.node.span):
                self._unknown.append((key, part.direction, unknown))
            return None
        fields = [f for f in definition.fields if f.type != _HEADER]
        if len(fields) != 1:
            names = first_of(f"{f.name}: {f.type}" for f in definition.fields)
            self._report.add(
                "no-single-field",
                part.node.span,
                f"{definition.name} has {len(fields) or 'no'} data fields,"
                f" so {carried} cannot stand for it",
                f"use a datatype object with: {names}" if fields else "use the type none",
            )
            return None
        problem = sent.misfit(carried, fields[0].type, part.sending)
        if problem is not None:
            code, message = problem
            self._report.add(
                code,
                part.node.span,
                f"{definition.name} has {fields[0].type} {fields[0].name}: {message}",
                "link another interface" if definition.name.startswith("std_msgs/") else None,
            )
        return fields[0].name

    def _check_object(
        self, object_: ObjectType, definition: Definition, sending: bool, span: Span
    ) -> list[_Unknown]:
        """Check an object against a definition, once; the properties that have no field."""
        if object_types.is_ros_type(object_):
            if object_.name != definition.name:
                message = f"the definition has {definition.name} here, not {object_.name}"
                self._report.add("field-kind", span, message)
            return []
        key = (object_, definition.name, sending)
        if key in self._checked:
            return self._checked[key]
        unknown = self._checked[key] = []
        for name, type_ in object_.properties:
            node = self._type_declarations.property_node(object_, name)
            field = definition.field(name)
            if field is None:
                if not self._type_declarations.is_misread(object_, name):
                    unknown.append(_Unknown(object_, (name,), node.name, definition))
                continue
            problem = sent.misfit(type_, field.type, sending)
            if problem is not None:
                code, message = problem
                self._report.add(
                    code,
                    node.type.span,
                    f"{definition.name} has {field.type} {name}: {message}",
                )
            else:
                self._note_length((object_, name), field.type, definition)
                unknown += [
                    replace(inner, path=(name, *inner.path))
                    for inner in self._descend(type_, field.type, sending, node.type.span)
                ]
        return unknown

    def _note_length(
        self, place: tuple[ObjectType, str], field: FieldType, definition: Definition
    ) -> None:
        if field.length is not None:
            found = (field.length, f"{place[1]} of {definition.name}")
            self.lengths[place] = min(found, self.lengths.get(place, found))

    def report_unknown_fields(self, usage: Usage) -> None:
        """Report properties without a field; an error only if they are read or sent."""
        found: dict[tuple[Span, str], tuple[_Unknown, bool]] = {}
        for key, direction, unknown in self._unknown:
            place = (unknown.property.span, unknown.definition.name)
            _, used = found.get(place, (unknown, False))
            found[place] = unknown, used or usage.uses(key, direction, unknown.path)
        for unknown, used in found.values():
            self._unknown_field(unknown, used)

    def _unknown_field(self, unknown: _Unknown, is_used: bool) -> None:
        definition, property_ = unknown.definition, unknown.property
        name = property_.text
        fields = first_of(f"{f.name}: {f.type}" for f in definition.fields) or "none at all"
        nearest = self._report.nearest(name, [f.name for f in definition.fields])
        known = f"its fields: {fields}"
        hint: remedies.Hint = known
        if definition.constant(name) is not None:
            hint = f"'{name}' is one of its constants\n{known}"
        elif nearest is not None:
            hint = remedies.followed(remedies.meant(nearest), known)
        if nearest is not None:
            # If the model uses the field's name elsewhere, the property is misspelt, not the use.
            key = (unknown.object.origin, unknown.object.name, nearest)
            uses = self._type_declarations.missed.get(key, ())
            is_used |= self._report.withdraw(uses)
        code = "unknown-field" if is_used else "unread-field"
        message = f"{definition.name} has no field '{name}'"
        self._report.add(code, property_.span, message, hint)

    def _descend(self, type_: Type, field: FieldType, sending: bool, span: Span) -> list[_Unknown]:
        if isinstance(type_, EnumType):
            type_ = type_.source
        while isinstance(type_, ArrayType):
            type_ = type_.element
        if isinstance(type_, EnumType):
            type_ = type_.source
        if not isinstance(type_, ObjectType):
            return []
        nested = self._definitions.fields(field.element)
        if isinstance(nested, Definition):
            return self._check_object(type_, nested, sending, span)
        if isinstance(nested, Missing):
            if nested.reason == "package":
                self.missing.of_package(nested, span)
            else:
                self._report.add(
                    "faulty-definition",
                    span,
                    f"the definition of {field.base} cannot be read",
                    nested.detail or f"{nested.package} has no such message",
                )
        return []

    def _binding(
        self, interface: Interface, parts: Sequence[Payload], fields: Sequence[str | None]
    ) -> Binding:
        pairs = zip(parts, fields, strict=True)
        names: dict[str, Any] = {f"{part.direction}_field": field for part, field in pairs}
        light = self._is_light(interface)
        return Binding(interface.package, interface.type, True, light=light, **names)

    def _is_light(self, interface: Interface) -> bool:
        """Whether a message has few bytes whatever is in it, the name of its frame apart."""
        return self._most_bytes(interface.parts[0]) <= LIGHT

    def _most_bytes(self, definition: Definition, around: tuple[str, ...] = ()) -> float:
        total = 0.0
        for type_ in (field.type for field in definition.fields if field.type != _HEADER):
            nested = self._definitions.fields(type_.element)
            if isinstance(nested, Missing) or (nested and nested.name in around):
                return inf
            if nested is not None:
                size = self._most_bytes(nested, (*around, definition.name))
            else:
                size = 8.0 if type_.base != "string" else type_.longest or inf
            most = type_.most if type_.length is None else type_.length
            total += max(size, 1.0) * ((inf if most is None else most) if type_.is_array else 1)
        return total


def is_legal(node: nodes.InterfaceNode) -> bool:
    """Whether ROS allows the names of an interface's type and package: they begin with a letter."""
    return node.type.text[0].isalpha() and node.package.text[0].isalpha()


def _basic_name(type_: Type) -> str:
    """The key of a type in ``BASIC``; empty for types without default message."""
    if isinstance(type_, IntegerType):
        return "integer"
    return "" if isinstance(type_, ObjectType | ArrayType | EnumType) else str(type_)
