"""What robosc wrote into a package, so that it knows later what is still as it left it.

The record is a file of the package. It has the layout of ``sha256sum``, so that
``sha256sum --check`` shows a person, too, which files were changed by hand.
"""

from __future__ import annotations

import re
from collections.abc import Mapping
from hashlib import sha256
from pathlib import Path

from robosc.emit.package.package import MARKER, File, Package
from robosc.emit.write.user_regions import text_of, with_own_lines

RECORD = "generated.sha256"

_LINE = re.compile(r"([0-9a-f]{64})  (.+)")


def record_of(package: Package) -> File:
    """The record of a package's files, as they are without lines of the user's own."""
    target = f" for {package.target}" if package.target else ""
    lines = [f"# What was {MARKER}{target}; it replaces and removes only what is still the same."]
    lines += [f"{_hash(file.content.encode())}  {path}" for path, file in package.files.items()]
    return File("\n".join(lines) + "\n")


def recorded_target(folder: Path) -> str:
    """The version of ROS that the package in a folder is for; empty if that is not recorded."""
    found = re.match(rf"# What was {MARKER} for (\w+);", text_of(folder / RECORD))
    return "" if found is None else found[1]


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
    """Whether a file of the package has the content that robosc gave it, the user's own lines
    apart."""
    place = folder / path
    if path not in record or not place.is_file():
        return False
    if any((folder / part).is_symlink() for part in (Path(path), *Path(path).parents)):
        return False  # it lies somewhere else, whatever it is
    own = with_own_lines(text_of(place), "").encode()
    return record[path] in (_hash(place.read_bytes()), _hash(own))


def _hash(content: bytes) -> str:
    return sha256(content).hexdigest()


def _is_below(path: str) -> bool:
    return not path.startswith("/") and ".." not in Path(path).parts
