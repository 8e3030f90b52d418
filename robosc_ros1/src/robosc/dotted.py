"""Names of the model that have parts: ``Base.drive``, and the paths of states, ``moving.fast``.

Nobody else takes them apart.
"""

from __future__ import annotations


def parts(name: str) -> list[str]:
    return name.split(".")


def first(name: str) -> str:
    """``Base`` of ``Base.drive``: the component of a communication, a variable or a state."""
    return name.partition(".")[0]


def inside(name: str) -> str:
    """``moving.fast`` of ``Base.moving.fast``: the name inside its component."""
    return name.partition(".")[2]


def last(name: str) -> str:
    """``drive`` of ``Base.drive``, and of ``drive``."""
    return name.rpartition(".")[2]


def around(path: str) -> str:
    """``moving`` of ``moving.fast``: the state around one; empty if it stands in none."""
    return path.rpartition(".")[0]
