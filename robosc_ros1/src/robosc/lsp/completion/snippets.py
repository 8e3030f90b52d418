"""Declarations with places to fill in, for completion: by the block in which they may stand."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path

from robosc.lazy_dataclasses import dataclass


@dataclass(frozen=True, slots=True)
class Snippet:
    """``label`` is what is offered, ``text`` what is inserted."""

    label: str
    meaning: str
    text: str


def _read() -> Mapping[str, list[Snippet]]:
    """Those of ``snippets.txt``, which says what its lines mean."""
    found: dict[str, list[Snippet]] = {}
    file = Path(__file__).with_name("snippets.txt")
    for part in file.read_text(encoding="utf-8").split("\n== ")[1:]:
        label, meaning, blocks, text = part.rstrip("\n").split("\n", 3)
        for block in blocks.split():
            found.setdefault(block, []).append(Snippet(label, meaning, text))
    return found


SNIPPETS = _read()
