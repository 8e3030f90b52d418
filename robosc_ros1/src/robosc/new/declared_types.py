"""Datatypes of a model for messages whose package is not on this machine, from definitions that
were recorded."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping

from robosc.language.keywords import escape
from robosc.model.ros.definitions import TIMES
from robosc.model.ros.interfaces import PARTS, WORDS, Definition, FieldType, Folder

_TIMES = {of.name: of for both in TIMES.values() for of in both.values()}
_ATTRIBUTES: Mapping[Folder, tuple[str, ...]] = {
    "msg": ("type",), "srv": ("request", "response"), "action": ("request", "response", "feedback"),
}  # fmt: skip


def parts(
    type_: str, folder: Folder, definitions: Mapping[str, Definition]
) -> tuple[Definition | None, ...]:
    """The definitions of the parts of an interface, as far as they were recorded; those of services
    and actions of ROS 2 may have an underline in their names."""
    return tuple(
        next((definitions[n] for n in (type_ + part, f"{type_}_{part}") if n in definitions), None)
        for part in PARTS[folder]
    )


class DeclaredTypes:
    """The declarations that a model needs; ``name`` gives a free identifier for a name of ROS."""

    def __init__(self, definitions: Mapping[str, Definition], name: Callable[[str], str]) -> None:
        self._definitions = {**_TIMES, **definitions}
        self._name = name
        self._objects: dict[str, str] = {}
        self._links: dict[str, str] = {}
        self.lines: list[str] = []

    def attributes(self, type_: str, folder: Folder) -> str:
        """The types of a communication, and its link: ``type: Horn links horn_type``."""
        found = parts(type_, folder, self._definitions)
        named = zip(_ATTRIBUTES[folder], found, strict=True)
        types = ", ".join(f"{attribute}: {self._object(part)}" for attribute, part in named)
        return f"{types} links {self._link(type_)}"

    def _link(self, type_: str) -> str:
        if type_ not in self._links:
            package, _, name = type_.partition("/")
            link = self._links[type_] = self._name(f"{name.lower()}_type")
            self.lines.append(f"    interface {link} use {escape(name)} from {escape(package)}\n")
        return self._links[type_]

    def _object(self, definition: Definition | None) -> str:
        """The object for a message; ``none`` for one without data."""
        if definition is None:
            return "none"
        known = self._objects.get(definition.name)
        if known is None:
            self._objects[definition.name] = "none"  # should it contain itself
            properties = [*self._properties(definition)]
            if not properties:
                return "none"
            known = self._objects[definition.name] = self._name(definition.name.rpartition("/")[2])
            self.lines.append(f"    datatype object {known} {{ {' '.join(properties)} }}\n")
        return known

    def _properties(self, definition: Definition) -> Iterator[str]:
        for field in definition.fields:
            type_ = self._field(field.type)
            if type_ != "none":
                yield f"{escape(field.name)}: {type_}"

    def _field(self, field: FieldType) -> str:
        base = WORDS.get(field.base) or self._object(self._definitions.get(field.base))
        return f"array({base})" if field.is_array and base != "none" else base
