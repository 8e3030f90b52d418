"""What robosc wrote into a package, so that it knows later what is still as it left it.

The record is a file of the package. It has the layout of ``sha256sum``, so that
``sha256sum --check`` tells a person, too, which files were changed by hand.
"""

from __future__ import annotations

import re
from collections.abc import Mapping
from hashlib import sha256
from pathlib import Path

from robosc.emit.package import MARKER, File

__all__ = ["RECORD", "is_as_recorded", "read_record", "record_of"]

RECORD = "generated.sha256"

_LINE = re.compile(r"([0-9a-f]{64})  (.+)")


def record_of(files: Mapping[str, File]) -> File:
    """The record of these files."""
    lines = [f"# What was {MARKER} here; it replaces and removes only what is still the same."]
    lines += [f"{sha256(file.content.encode()).hexdigest()}  {p}" for p, file in files.items()]
    return File("\n".join(lines) + "\n")


def read_record(folder: Path) -> dict[str, str] | None:
    """The hashes by path; empty without a record, None if the file is none.

    Lines that are not as robosc writes them count for nothing, as after a failed merge: what they
    spoke of is then a file that anybody may have written.
    """
    place = folder / RECORD
    if not place.is_symlink() and not place.exists():
        return {}
    if place.is_symlink() or not place.is_file():
        return None
    text = place.read_text(encoding="utf-8", errors="replace")
    if MARKER not in text.partition("\n")[0]:
        return None
    found = (_LINE.fullmatch(line) for line in text.splitlines())
    return {match[2]: match[1] for match in found if match and _is_below(match[2])}


def is_as_recorded(folder: Path, path: str, record: Mapping[str, str]) -> bool:
    """Whether a file of the package has the content that robosc gave it."""
    place = folder / path
    if path not in record or not place.is_file():
        return False
    if any((folder / part).is_symlink() for part in (Path(path), *Path(path).parents)):
        return False  # it lies somewhere else, whatever it is
    return sha256(place.read_bytes()).hexdigest() == record[path]


def _is_below(path: str) -> bool:
    return not path.startswith("/") and ".." not in Path(path).parts
