"""Definitions as recordings have them: that of a type, and those that it needs, in one text."""

from __future__ import annotations

import re
from collections.abc import Iterator

from robosc.model.ros import genmsg_text, rosidl
from robosc.model.ros.interfaces import Definition, Folder

_LINE = "=" * 80
_SECTION = re.compile(r"(?:MSG|SRV|ACTION|IDL):[ \t]*(\S+)[ \t]*\n?")
_SEPARATOR = re.compile(rf"^{_LINE}[ \t\r]*\n", re.MULTILINE)
_PART = re.compile(r"^---", re.MULTILINE)

_OF_EVENTS = (("info", "service_msgs/ServiceEventInfo"),)
_OF_FEEDBACK = (("goal_id", "unique_identifier_msgs/UUID"),)


def definitions(text: str, type_: str, schema: str) -> dict[str, Definition]:
    """The definitions in a recorded text, by names like ``geometry_msgs/Vector3``.

    ``type_`` is that of the first one, as it was recorded; ``schema`` the language: ``ros1msg``,
    ``ros2msg`` or ``ros2idl``.

    Raises:
        ValueError: the text is faulty; says what is wrong in which type.
    """
    found: dict[str, Definition] = {}
    for name, section, is_idl in _sections(text.replace("\r\n", "\n"), type_, schema):
        package, _, rest = name.partition("/")
        try:
            for definition in _read(section, package, rest.rpartition("/")[2], schema, is_idl):
                found.setdefault(definition.name, definition)
        except ValueError as error:
            raise ValueError(f"the definition of {name}: {error}") from None
    return found


def _sections(text: str, type_: str, schema: str) -> Iterator[tuple[str, str, bool]]:
    """Name and text of each type, and whether that is IDL."""
    for section in _SEPARATOR.split(text):
        title = _SECTION.match(section)
        if title is not None:
            yield title[1], section[title.end() :], section.startswith("IDL")
        elif section.strip() or not text.strip():
            yield type_, section, schema == "ros2idl"


def _read(text: str, package: str, name: str, schema: str, is_idl: bool) -> Iterator[Definition]:
    stem = name.removesuffix("_Event")
    parts = len(_PART.findall(text))
    if is_idl:
        structs = rosidl.idl_structs(text, package)
        yield from structs.values()
        if stem != name and name not in structs:
            yield _event(package, stem, "_")
        return
    if schema == "ros1msg" or not parts:
        read = genmsg_text.parts if schema == "ros1msg" else rosidl.texts
        yield from read(text, package, name, "msg")
        return
    # A service or an action, whose parts are in one text.
    folder: Folder = "srv" if parts == 1 else "action"
    stem = stem.removesuffix("_FeedbackMessage")
    yield from rosidl.texts(text, package, stem, folder)
    if folder == "srv":
        yield _event(package, stem, "")
    else:
        fields = (*_OF_FEEDBACK, ("feedback", f"{package}/{stem}Feedback"))
        yield Definition.of(f"{package}/{stem}_FeedbackMessage", fields)


def _event(package: str, stem: str, joint: str) -> Definition:
    """The message in which a service tells of its calls."""
    calls = ((part.lower(), f"{package}/{stem}{joint}{part}[]") for part in ("Request", "Response"))
    return Definition.of(f"{package}/{stem}_Event", (*_OF_EVENTS, *calls))
