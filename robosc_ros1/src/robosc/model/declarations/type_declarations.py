"""The declarations of data types in all files of a run, and the errors in them."""

from __future__ import annotations

from dataclasses import dataclass, field

from robosc.errors import Diagnostic
from robosc.expr.types import EnumType, ObjectType, Type
from robosc.language.keywords import BASIC_TYPES
from robosc.model.ros.definitions import MessageDefinitions
from robosc.model.ros.object_types import RosTypes
from robosc.syntax.nodes import EnumNode, EnumRuleNode, ObjectNode, PropertyNode


@dataclass
class TypeDeclarations:
    """The declarations of data types by (origin, name), shared by all files of one run.

    ``unknown_properties`` are properties whose type has an error, ``unknown_sources`` enums whose
    source type has one, ``damaged`` the declarations of which a part did not parse; ``missed`` are
    the diagnostics about properties that an object does not have; ``ros`` are the types that ROS
    packages define.
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
        """Whether an unknown property or value may have been declared, with an error."""
        key = (type_.origin, type_.name)
        return key in self.damaged or (*key, name) in self.unknown_properties

    def miss(self, type_: ObjectType, name: str, diagnostic: Diagnostic) -> None:
        """Record the diagnostic that an object has no such property."""
        self.missed.setdefault((type_.origin, type_.name, name), []).append(diagnostic)

    def is_misread(self, type_: ObjectType, name: str) -> bool:
        """Whether the name of a property may be the type of one whose name is missing."""
        origin = type_.origin
        is_type = name in BASIC_TYPES or (origin, name) in self.nodes
        return is_type and (origin, type_.name) in self.damaged

    def value_node(self, enum: EnumType, value: str) -> EnumRuleNode | None:
        """The rule that declares an enum's value: the first one that gives it."""
        node = self.nodes.get((enum.origin, enum.name))
        return rule_of(node, value) if isinstance(node, EnumNode) else None

    def is_known(self, type_: Type) -> bool:
        """Whether a type has no unknown source type, as an enum with an error has."""
        return (
            not isinstance(type_, EnumType)
            or (type_.origin, type_.name) not in self.unknown_sources
        )


def rule_of(node: EnumNode, value: str) -> EnumRuleNode | None:
    """The first rule that gives a value."""
    return next((rule for rule in node.rules if rule.value.text == value), None)
