"""Regions of generated files that belong to the user and outlive the next generation.

A region lies between two lines that say so, in whatever the file has for comments: dependencies and
nodes of the user's own go there.
"""

from __future__ import annotations

import re
from pathlib import Path

_REGION = re.compile(
    r"(begin of your own lines\b[^\n]*\n)(.*?)(^[^\n]*\bend of your own lines\b)",
    re.DOTALL | re.MULTILINE,
)


def own_lines(text: str) -> str:
    """Return what stands in the region of a text; empty if nothing does, or without a region."""
    found = _REGION.search(text)
    return "" if found is None else found[2]


def with_own_lines(text: str, lines: str) -> str:
    """Return the text with these lines in its region; the same text if it has none."""
    return _REGION.sub(lambda found: found[1] + lines + found[3], text, count=1)


def text_of(path: Path) -> str:
    """Return the content of a file; empty if there is no file, or no text in it."""
    try:
        return path.read_bytes().decode()
    except (OSError, UnicodeDecodeError):
        return ""
