"""The files behind ROS interfaces, and what they hold in terms of the language."""

from __future__ import annotations

import re
from collections.abc import Sequence
from pathlib import Path

from robosc.model.ros.definitions import MessageDefinitions
from robosc.model.ros.interfaces import INTEGERS, KINDS, FieldType
from robosc.source import Source, Span


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
    base = field.base
    if base in INTEGERS:
        word = "integer"
    elif base == "bool":
        word = "boolean"
    elif base in ("float32", "float64"):
        word = "double"
    elif base == "string":
        word = "string"
    else:
        word = base.rpartition("/")[2].capitalize() if "/" not in base else base.rpartition("/")[2]
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
