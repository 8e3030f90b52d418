"""Messages, services and actions of ROS as object types of the language.

A model can use ``sensor_msgs/LaserScan`` as a type without declaring an object for it.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping

from robosc.expr import types
from robosc.model.ros import interfaces
from robosc.model.ros.definitions import MessageDefinitions

_ROS = ""
"""The origin of types that no model declares."""


DURATIONS: Mapping[str, tuple[str, str]] = {
    "duration": ("secs", "nsecs"),
    "builtin_interfaces/Duration": ("sec", "nanosec"),
}
"""The types of durations in both versions of ROS, each with its fields."""

TIMES = ("time", "builtin_interfaces/Time")
"""The types of points in time in both versions of ROS."""


def is_ros_type(type_: types.ObjectType) -> bool:
    """Whether an object is a message of ROS, or a part of a service or action."""
    return type_.origin == _ROS


class RosTypes:
    """The types of ROS definitions, each made once."""

    def __init__(self, definitions: MessageDefinitions) -> None:
        self.definitions = definitions
        self._objects: dict[str, types.ObjectType | types.NoneType | interfaces.Missing] = {}
        self.lengths: dict[tuple[types.ObjectType, str], tuple[int, str]] = {}
        """Array fields of fixed length: the number of elements, and the field as text."""
        self.absent: dict[str, list[tuple[str, interfaces.Missing]]] = {}
        """By the names of messages: fields whose types are of packages that are not found."""

    def constants(self, package: str, name: str) -> Mapping[str, types.Value] | interfaces.Missing:
        """The constants of the message, service or action of a name, the first there is."""
        missing: list[interfaces.Missing] = []
        for folder in interfaces.KINDS:
            found = self.definitions.interface(package, name, folder)
            if isinstance(found, interfaces.Interface):
                return dict(constant for part in found.parts for constant in part.constants)
            missing.append(found)
        return missing[0]

    def part(
        self, package: str, name: str, folder: interfaces.Folder, index: int
    ) -> types.Type | interfaces.Missing:
        """The type of one part of an interface; ``none`` for one without fields."""
        found = self.definitions.interface(package, name, folder)
        return found if isinstance(found, interfaces.Missing) else self._object(found.parts[index])

    def absent_in(self, type_: types.Type) -> Iterator[tuple[str, interfaces.Missing]]:
        """The fields of a message, at any depth, whose types are of packages that are not found."""
        if isinstance(type_, types.ArrayType):
            yield from self.absent_in(type_.element)
        elif isinstance(type_, types.ObjectType) and is_ros_type(type_):
            yield from self.absent.get(type_.name, ())
            for _, inner in type_.properties:
                yield from self.absent_in(inner)

    def _object(
        self, definition: interfaces.Definition
    ) -> types.ObjectType | types.NoneType | interfaces.Missing:
        known = self._objects.get(definition.name)
        if known is None:
            known = self._objects[definition.name] = self._made(definition)
        return known

    def _made(
        self, definition: interfaces.Definition
    ) -> types.ObjectType | types.NoneType | interfaces.Missing:
        properties: list[tuple[str, types.Type]] = []
        for field in definition.fields:
            type_ = self._field(field.type)
            if isinstance(type_, interfaces.Missing):
                if type_.reason != "package":
                    return type_
                known = self.absent.setdefault(definition.name, [])
                known.append((f"{field.name} of {definition.name}", type_))
            elif not isinstance(type_, types.NoneType):
                properties.append((field.name, type_))
        if not definition.fields:
            return types.NoneType()
        made = types.ObjectType(definition.name, _ROS, tuple(properties))
        for field in definition.fields:
            if field.type.length is not None:
                words = f"{field.name} of {definition.name}"
                self.lengths[made, field.name] = (field.type.length, words)
        return made

    def _field(self, field: interfaces.FieldType) -> types.Type | interfaces.Missing:
        element = self._element(field)
        if isinstance(element, interfaces.Missing | types.NoneType) or not field.is_array:
            return element
        return types.ArrayType(element)

    def _element(self, field: interfaces.FieldType) -> types.Type | interfaces.Missing:
        base = field.base
        if base in interfaces.WORDS:
            return types.TYPES_BY_WORD[interfaces.WORDS[base]]
        nested = self.definitions.fields(field.element)
        if nested is None:
            return interfaces.Missing("faulty", base, detail=f"the type {base} is not known")
        return nested if isinstance(nested, interfaces.Missing) else self._object(nested)
