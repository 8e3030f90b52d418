"""The declarations of data types, from which types are made."""

from __future__ import annotations

from dataclasses import dataclass, field

from robosc.errors import Diagnostic
from robosc.language.keywords import BASIC_TYPES
from robosc.model.ros.definitions import MessageDefinitions
from robosc.model.ros.types import RosTypes
from robosc.model.types import EnumType, ObjectType, Type
from robosc.syntax.nodes import EnumNode, EnumRuleNode, ObjectNode, PropertyNode

__all__ = ["TypeDeclarations", "rule_of"]


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
