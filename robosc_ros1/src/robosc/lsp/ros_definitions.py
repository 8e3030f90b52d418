"""The real ROS definitions that carry a file's communications and objects."""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from pathlib import Path

from robosc.expr.types import ArrayType, EnumType, NoneType, ObjectType, Type
from robosc.model.file_resolver import FileContents
from robosc.model.names.tables import CommunicationInfo
from robosc.model.ros.definitions import BASIC, MessageDefinitions
from robosc.model.ros.interfaces import KINDS, WORDS, Definition, Field, FieldType, Interface
from robosc.model.ros.sent import misfit
from robosc.source import Source, Span
from robosc.syntax.nodes import InterfaceNode


def interface_of(info: CommunicationInfo, definitions: MessageDefinitions) -> Interface | None:
    """The real definition that carries a communication."""
    links = info.node.links
    if links is None:
        binding = info.entity.binding if info.entity is not None else None
        return next((i for i in BASIC.values() if binding and i.type == binding.type), None)
    owner = info.instance.types.owner(links)
    interface = None if owner is None else owner.scope.interfaces.get(links.name.text)
    return _definition(info, interface, definitions) if interface is not None else None


def _definition(
    info: CommunicationInfo, node: InterfaceNode, definitions: MessageDefinitions
) -> Interface | None:
    """What a declared interface is for a communication of this kind."""
    package, type_ = node.package.text, node.type.text
    found = definitions.interface(package, type_, info.sort.folder)
    return found if isinstance(found, Interface) else None


def fits(info: CommunicationInfo, node: InterfaceNode, definitions: MessageDefinitions) -> bool:
    """Whether a declared interface has a place for all that a communication carries."""
    interface = _definition(info, node, definitions)
    if interface is None:
        return False
    for (direction, type_), part in zip(info.types.items(), interface.parts, strict=True):
        if not _fits_into(type_, part, direction in info.sort.sent):
            return False
    return True


def _fits_into(type_: Type | None, part: Definition, sending: bool) -> bool:
    carried = type_.source if isinstance(type_, EnumType) else type_
    if isinstance(carried, NoneType):
        return True
    pairs: list[tuple[Type | None, Field | None]]
    if isinstance(carried, ObjectType):
        pairs = [(inner, part.field(name)) for name, inner in carried.properties]
    else:
        data = [field for field in part.fields if field.type.base != "std_msgs/Header"]
        pairs = [(carried, data[0] if len(data) == 1 else None)]
    return all(
        inner is not None and field is not None and misfit(inner, field.type, sending) is None
        for inner, field in pairs
    )


def carriers(contents: FileContents, definitions: MessageDefinitions) -> Mapping[str, Definition]:
    """The definition behind each object datatype that the file declares, where one carries it."""
    found: dict[str, Definition] = {}
    for instance in contents.instances.values():
        for info in instance.communications.values():
            interface = interface_of(info, definitions)
            if interface is None or instance.types.scope is not contents.scope:
                continue
            for type_, part in zip(info.types.values(), interface.parts, strict=False):
                _carry(type_, part, definitions, found)
    return found


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


# The files behind ROS interfaces, and what they hold in terms of the language.


def definition_file(definitions: MessageDefinitions, package: str, type_: str) -> Path | None:
    """The ``.msg``, ``.srv`` or ``.action`` file of an interface, if there is one."""
    home = definitions.packages.find(package)
    if home is None:
        return None
    names = [(type_, folder) for folder in KINDS]
    names.append((type_.removesuffix("Action"), "action"))
    for name, folder in names:
        file = home / folder / f"{name}.{folder}"
        if file.is_file():
            return file
    return None


def field_place(file: Path, part: int, name: str) -> Span:
    """Where a field is declared in a part (0, 1, 2) of a file; its beginning if it is not."""
    try:
        text = file.read_text(encoding="utf-8", errors="replace")
    except OSError:
        text = ""
    source = Source(str(file), text.replace("\r\n", "\n"))
    begins = [0, *(m.end() for m in re.finditer(r"^---.*$", source.text, re.MULTILINE))]
    start = begins[part] if part < len(begins) else 0
    pattern = re.compile(rf"^[ \t]*[\w/\[\]<=]+[ \t]+({re.escape(name)})\b", re.MULTILINE)
    found = pattern.search(source.text, start) if name else None
    return Span(source, found.start(1), found.end(1)) if found else Span(source, 0, 0)


def model_type(field: FieldType) -> str:
    """The type of the language that fits a field; a message becomes an object of its name."""
    package, _, name = field.base.rpartition("/")
    word = WORDS.get(field.base) or (name if package else name.capitalize())
    return f"array({word})" if field.is_array else word


def offered_types(definitions: MessageDefinitions) -> Sequence[tuple[str, str, str]]:
    """Package, type and folder of all interfaces that can be used, each package once."""
    found: dict[tuple[str, str, str], None] = {}
    for package, home in definitions.packages.all().items():
        for folder in KINDS:
            try:
                names = sorted(f.stem for f in (home / folder).glob(f"*.{folder}"))
            except OSError:
                continue
            for name in names:
                found.setdefault((package, name, folder))
    return list(found)
