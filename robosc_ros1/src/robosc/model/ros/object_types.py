"""Messages, services and actions of ROS as object types of the language.

A model can use ``sensor_msgs/LaserScan`` as a type without declaring an object for it.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping

from robosc.expr.types import (
    ArrayType,
    BooleanType,
    DoubleType,
    IntegerType,
    NoneType,
    ObjectType,
    StringType,
    Type,
    Value,
)
from robosc.model.ros.definitions import MessageDefinitions
from robosc.model.ros.interfaces import (
    INTEGERS,
    KINDS,
    Definition,
    FieldType,
    Folder,
    Interface,
    Missing,
)
from robosc.syntax.nodes import (
    ActionNode,
    CommunicationNode,
    MessageNode,
    ServedActionNode,
    ServedServiceNode,
    ServiceNode,
    TransformNode,
)

FOLDERS: Mapping[type[CommunicationNode], Folder] = {
    MessageNode: "msg",
    TransformNode: "msg",
    ServiceNode: "srv",
    ServedServiceNode: "srv",
    ActionNode: "action",
    ServedActionNode: "action",
}
"""The folder of the definition of each kind of communication."""

_ROS = ""
"""The origin of types that no model declares."""


DURATIONS: Mapping[str, tuple[str, str]] = {
    "duration": ("secs", "nsecs"),
    "builtin_interfaces/Duration": ("sec", "nanosec"),
}
"""The types of durations in both versions of ROS, each with its fields."""

TIMES = ("time", "builtin_interfaces/Time")
"""The types of points in time in both versions of ROS."""


def is_ros_type(type_: ObjectType) -> bool:
    """Whether an object is a message of ROS, or a part of a service or action."""
    return type_.origin == _ROS


class RosTypes:
    """The types of ROS definitions, each made once."""

    def __init__(self, definitions: MessageDefinitions) -> None:
        self.definitions = definitions
        self._objects: dict[str, ObjectType | NoneType | Missing] = {}
        self.lengths: dict[tuple[ObjectType, str], tuple[int, str]] = {}
        """Array fields of fixed length: the number of elements, and the field as text."""
        self.absent: dict[str, list[tuple[str, Missing]]] = {}
        """By the names of messages: fields whose types are of packages that are not found."""

    def constants(self, package: str, name: str) -> Mapping[str, Value] | Missing:
        """The constants of the message, service or action of a name, the first there is."""
        missing: list[Missing] = []
        for folder in KINDS:
            found = self.definitions.interface(package, name, folder)
            if isinstance(found, Interface):
                return dict(constant for part in found.parts for constant in part.constants)
            missing.append(found)
        return missing[0]

    def part(self, package: str, name: str, folder: Folder, index: int) -> Type | Missing:
        """The type of one part of an interface; ``none`` for one without fields."""
        found = self.definitions.interface(package, name, folder)
        return found if isinstance(found, Missing) else self._object(found.parts[index])

    def absent_in(self, type_: Type) -> Iterator[tuple[str, Missing]]:
        """The fields of a message, at any depth, whose types are of packages that are not found."""
        if isinstance(type_, ArrayType):
            yield from self.absent_in(type_.element)
        elif isinstance(type_, ObjectType) and is_ros_type(type_):
            yield from self.absent.get(type_.name, ())
            for _, inner in type_.properties:
                yield from self.absent_in(inner)

    def _object(self, definition: Definition) -> ObjectType | NoneType | Missing:
        known = self._objects.get(definition.name)
        if known is None:
            known = self._objects[definition.name] = self._made(definition)
        return known

    def _made(self, definition: Definition) -> ObjectType | NoneType | Missing:
        properties: list[tuple[str, Type]] = []
        for field in definition.fields:
            type_ = self._field(field.type)
            if isinstance(type_, Missing):
                if type_.reason != "package":
                    return type_
                known = self.absent.setdefault(definition.name, [])
                known.append((f"{field.name} of {definition.name}", type_))
            elif not isinstance(type_, NoneType):
                properties.append((field.name, type_))
        if not definition.fields:
            return NoneType()
        made = ObjectType(definition.name, _ROS, tuple(properties))
        for field in definition.fields:
            if field.type.length is not None:
                words = f"{field.name} of {definition.name}"
                self.lengths[made, field.name] = (field.type.length, words)
        return made

    def _field(self, field: FieldType) -> Type | Missing:
        element = self._element(field)
        if isinstance(element, Missing | NoneType) or not field.is_array:
            return element
        return ArrayType(element)

    def _element(self, field: FieldType) -> Type | Missing:
        base = field.base
        if base in INTEGERS:
            return IntegerType()
        match base:
            case "bool":
                return BooleanType()
            case "float32" | "float64":
                return DoubleType()
            case "string":
                return StringType()
        nested = self.definitions.fields(field.element)
        if nested is None:
            return Missing("faulty", base, detail=f"the type {base} is not known")
        return nested if isinstance(nested, Missing) else self._object(nested)
