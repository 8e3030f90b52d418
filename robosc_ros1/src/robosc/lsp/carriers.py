"""The real ROS definitions that carry a file's communications and objects."""

from __future__ import annotations

from collections.abc import Mapping

from robosc.model.file_resolver import FileContents
from robosc.model.ros.definitions import BASIC, Definition, Interface, MessageDefinitions
from robosc.model.tables import CommunicationInfo
from robosc.model.types import ArrayType, EnumType, ObjectType, Type
from robosc.syntax.nodes import ActionNode, MessageNode, ServiceNode

__all__ = ["carriers", "interface_of"]


def interface_of(info: CommunicationInfo, definitions: MessageDefinitions) -> Interface | None:
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
            found = definitions.message(package, type_)
        case ServiceNode():
            found = definitions.service(package, type_)
        case ActionNode():
            found = definitions.action(package, type_)
    return found if isinstance(found, Interface) else None


def carriers(contents: FileContents, definitions: MessageDefinitions) -> Mapping[str, Definition]:
    """The definition behind each object datatype that the file declares, where one carries it."""
    found: dict[str, Definition] = {}
    for instance in contents.instances.values():
        for info in instance.communications.values():
            interface = interface_of(info, definitions)
            if interface is None or instance.types.scope is not contents.scope:
                continue
            for type_, part in zip(_parts(info), interface.parts, strict=False):
                _carry(type_, part, definitions, found)
    return found


def _parts(info: CommunicationInfo) -> tuple[Type | None, ...]:
    match info.node:
        case MessageNode(direction="incoming"):
            return (info.request,)
        case MessageNode():
            return (info.response,)
        case ServiceNode():
            return info.request, info.response
        case ActionNode():
            return info.request, info.response, info.feedback


def _carry(
    type_: Type | None,
    part: Definition,
    definitions: MessageDefinitions,
    found: dict[str, Definition],
) -> None:
    while isinstance(type_, ArrayType | EnumType):
        type_ = type_.element if isinstance(type_, ArrayType) else type_.source
    if not isinstance(type_, ObjectType) or type_.name in found:
        return
    found[type_.name] = part
    for name, inner in type_.properties:
        field = part.field(name)
        nested = definitions.fields(field.type.element) if field is not None else None
        if isinstance(nested, Definition):
            _carry(inner, nested, definitions, found)
