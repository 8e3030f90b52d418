"""Hints that an editor can carry out: their words for people, and what is to be done.

Each kind is carried out by a rule of :mod:`robosc.lsp.actions`.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from enum import Enum
from typing import TypeAlias

from robosc.lazy_dataclasses import dataclass


class Change(Enum):
    """What is to be done, and with which parts."""

    REPLACE = "replace"
    """Write one of the parts in place of what is marked."""
    REMOVE = "remove"
    """Remove what is marked, with its line if nothing else is on it."""
    REMOVE_INITIAL = "remove initial"
    """Remove 'initial' from what is marked, a state's name."""
    CLOSE = "close"
    """Write the sign that closes what is marked."""
    ADD_DEFAULT = "add default"
    """Add a rule to the enum around what is marked."""
    MAKE_INITIAL = "make initial"
    """Make a state of the component around what is marked the initial one."""
    ADD_INITIAL = "add initial"
    """Add a state to the behaviour of the component around what is marked."""
    LINK = "link"
    """Link to an interface that fits, else to one of this name, with this declaration if given."""
    ADD_IMPORT = "add import"
    """Add an import below the one that is marked."""
    ADD_TRANSITION = "add transition"
    """Add a transition, in a state, of a component."""
    ADD_TIMEOUT = "add timeout"
    """Add to a message its timeout."""
    ADD_FRESHNESS = "add freshness"
    """Add to a message its timeout, and a requirement for one of the other parts, the commands."""


@dataclass(frozen=True, slots=True)
class Remedy:
    """A hint that an editor can carry out; ``text`` is what people read."""

    text: str
    change: Change
    parts: tuple[str, ...] = ()


Hint: TypeAlias = str | Remedy


def meant(name: str) -> Remedy:
    """``did you mean 'x'?``."""
    return Remedy(f"did you mean '{name}'?", Change.REPLACE, (name,))


def followed(hint: Hint | None, line: str) -> Hint:
    """A hint with a line below it."""
    if isinstance(hint, Remedy):
        return replace(hint, text=f"{hint.text}\n{line}")
    return f"{hint}\n{line}" if hint else line


def write(text: str, more: str = "") -> Remedy:
    """``write 'x'``, perhaps with more behind it."""
    return Remedy(f"write '{text}'{more}", Change.REPLACE, (text,))


def write_one(texts: Sequence[str]) -> Remedy:
    """``write A.x or B.x``."""
    return Remedy(f"write {' or '.join(texts)}", Change.REPLACE, tuple(texts))
