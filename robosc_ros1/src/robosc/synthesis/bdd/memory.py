"""How many bytes the decision diagrams may take: what is free, and what the process is allowed."""

from __future__ import annotations

import re
import sys
from pathlib import Path

from robosc.errors import StateSpaceError

__all__ = ["DEFAULT_MEMORY", "budget", "has_room"]

DEFAULT_MEMORY = 2 * 2**30
"""Bytes that the diagrams of one synthesis may take where there is enough of them."""

_BESIDE = 128 * 2**20
"""Bytes that the rest of a synthesis takes beside the diagrams."""
_STACK = 2**30 + 2**27
"""Bytes of address space, though not of memory, that the library takes for its own thread."""
_LEAST = 64 * 2**20
"""With less than that for the diagrams it is not worth beginning."""


def has_room() -> bool:
    """Whether a synthesis with diagrams is worth beginning."""
    return _free() >= _LEAST


def budget(wanted: int = DEFAULT_MEMORY) -> int:
    """Return how many bytes the diagrams may take, ``wanted`` at the most.

    The library ends the whole process when the system gives it no memory, so it must not be
    allowed more than there is.

    Raises:
        StateSpaceError: it is too little for any synthesis.
    """
    free = _free()
    if free < min(_LEAST, wanted):
        raise StateSpaceError(
            "the symbolic engine has too little memory:"
            f" it needs {(min(_LEAST, wanted) - free) // 2**20 + 1} MB more than are free"
            " or 'ulimit -v' allows"
        )
    return min(wanted, free)


def _free() -> int:
    """Bytes for diagrams; less than nothing if not even the library itself has room."""
    return min(_available(), _below_limit() - _STACK) - _BESIDE


def _available() -> int:
    """Bytes that the machine can give without swapping; any number where that is not told."""
    try:
        text = Path("/proc/meminfo").read_text(encoding="ascii")
    except OSError:
        return 2**62
    found = re.search(r"^MemAvailable:\s*(\d+) kB", text, re.MULTILINE)
    return int(found[1]) * 1024 if found else 2**62


def _below_limit() -> int:
    """Bytes of address space that this process may still take."""
    if sys.platform == "win32":
        return 2**62
    import resource

    limit, _ = resource.getrlimit(resource.RLIMIT_AS)
    if limit == resource.RLIM_INFINITY:
        return 2**62
    try:
        pages = int(Path("/proc/self/statm").read_text(encoding="ascii").split()[0])
    except OSError:
        return limit // 2
    return limit - pages * resource.getpagesize()
