"""Definitions from the Python bindings that genpy generates.

Some Debian packages install bindings without definition files (those of actionlib's actions are an
example). The bindings have all fields and types, but not the constants. They are read as text:
nothing is imported.
"""

from __future__ import annotations

import ast
from collections.abc import Iterator
from pathlib import Path

from robosc.model.ros.interfaces import PARTS, Definition, Folder


def read(bindings: Path, package: str, type_: str, folder: Folder) -> tuple[Definition, ...] | None:
    """The parts of a message, service or action; None if it is not there or not readable."""
    # TAction's bindings exist beside TGoal's; an action T is only what has both.
    if folder == "action" and not (bindings / "msg" / f"_{type_}Action.py").is_file():
        return None
    found = []
    for part in PARTS[folder]:
        # The bindings of a service are in one file, those of an action's parts in one each.
        file = f"srv/_{type_}.py" if folder == "srv" else f"msg/_{type_}{part}.py"
        fields = _fields(bindings / file, f"{type_}{part}")
        if fields is None:
            return None
        found.append(Definition.of(f"{package}/{type_}{part}", fields))
    return tuple(found)


def names(package: Path, folder: str) -> Iterator[str]:
    """The messages, services or actions that a package has bindings for."""
    where = package / ("srv" if folder == "srv" else "msg")
    for file in sorted(where.glob("_[A-Za-z]*.py")):
        name = file.stem[1:]
        if folder != "action":
            yield name
        elif name.endswith("ActionGoal"):
            yield name.removesuffix("ActionGoal")


def _fields(file: Path, name: str) -> list[tuple[str, str]] | None:
    """Name and type of each field of a class."""
    try:
        module = ast.parse(file.read_bytes())
        (found,) = (n for n in module.body if isinstance(n, ast.ClassDef) and n.name == name)
        values = {
            ast.unparse(statement.targets[0]): statement.value
            for statement in found.body
            if isinstance(statement, ast.Assign)
        }
        slots, types = (ast.literal_eval(values[key]) for key in ("__slots__", "_slot_types"))
        return list(zip(slots, types, strict=True))
    except (OSError, SyntaxError, ValueError, KeyError):
        return None
