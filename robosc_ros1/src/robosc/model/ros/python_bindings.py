"""Definitions from the Python bindings that genpy generates.

Some Debian packages install bindings without definition files (those of actionlib's actions are an
example). The bindings have all fields and types, but not the constants. They are read as text:
nothing is imported.
"""

from __future__ import annotations

import ast
import re
from collections.abc import Iterator
from pathlib import Path

__all__ = ["Slots", "names", "read"]

Slots = tuple[tuple[str, str], ...]
"""Name and type of each field."""

_CLASS = re.compile(r"^class (\w+)\(", re.MULTILINE)
_SLOTS = re.compile(r"^  __slots__ = (\[[^\]]*\])", re.MULTILINE)
_TYPES = re.compile(r"^  _slot_types = (\[.*?\])$", re.MULTILINE)


def read(package: Path, type_: str, folder: str) -> tuple[Slots, ...] | None:
    """The parts of a message, service or action; None if it is not there or not readable."""
    if folder == "action":
        # TAction's bindings exist beside TGoal's; an action T is only what has both.
        if not (package / "msg" / f"_{type_}Action.py").is_file():
            return None
        parts = [_slots(package / "msg", f"{type_}{p}") for p in ("Goal", "Result", "Feedback")]
    elif folder == "srv":
        file = package / "srv" / f"_{type_}.py"
        parts = [_slots_in(file, f"{type_}{p}") for p in ("Request", "Response")]
    else:
        parts = [_slots(package / "msg", type_)]
    found = tuple(p for p in parts if p is not None)
    return found if len(found) == len(parts) else None


def names(package: Path, folder: str) -> Iterator[str]:
    """The messages, services or actions that a package has bindings for."""
    where = package / ("srv" if folder == "srv" else "msg")
    for file in sorted(where.glob("_[A-Za-z]*.py")):
        name = file.stem[1:]
        if folder != "action":
            yield name
        elif name.endswith("ActionGoal"):
            yield name.removesuffix("ActionGoal")


def _slots(folder: Path, name: str) -> Slots | None:
    return _slots_in(folder / f"_{name}.py", name)


def _slots_in(file: Path, name: str) -> Slots | None:
    try:
        text = file.read_text(encoding="utf-8", errors="replace")
    except OSError:
        return None
    heads = list(_CLASS.finditer(text))
    for head, following in zip(heads, [*heads[1:], None], strict=True):
        if head[1] == name:
            return _fields(text[head.start() : following.start() if following else len(text)])
    return None


def _fields(text: str) -> Slots | None:
    slots, types = _SLOTS.search(text), _TYPES.search(text)
    if slots is None or types is None:
        return None
    try:
        return tuple(zip(ast.literal_eval(slots[1]), ast.literal_eval(types[1]), strict=True))
    except (ValueError, SyntaxError):
        return None
