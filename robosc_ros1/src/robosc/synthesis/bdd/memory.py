"""The memory for decision diagrams: what is free, and what the process is allowed."""

from __future__ import annotations

import re
import sys
from pathlib import Path

from robosc import limits
from robosc.errors import StateSpaceError

_BESIDE = 128 * 2**20
"""Bytes for the rest of a synthesis."""
_STACK = 2**30 + 2**27
"""Bytes of address space, not of memory, that the library reserves for its own thread."""
_LEAST = 64 * 2**20
"""Bytes for the diagrams below which a synthesis is not started."""


def has_room() -> bool:
    """Whether there is enough memory to start a symbolic synthesis."""
    return _free() >= _LEAST


def budget(wanted: int = limits.MEMORY) -> int:
    """Return how many bytes the diagrams may take, ``wanted`` at the most.

    The library aborts the whole process when an allocation fails, so it must not be allowed more
    than is free.

    Raises:
        StateSpaceError: too little is free for any synthesis.
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
    """Return the bytes free for diagrams; negative if not even the library itself has room."""
    return min(_available(), _below_limit() - _STACK) - _BESIDE


def _available() -> int:
    """Return the bytes available without swapping; 2**62 if the system does not report them."""
    try:
        text = Path("/proc/meminfo").read_text(encoding="ascii")
    except OSError:
        return 2**62
    found = re.search(r"^MemAvailable:\s*(\d+) kB", text, re.MULTILINE)
    return int(found[1]) * 1024 if found else 2**62


def _below_limit() -> int:
    """Return the bytes of address space that this process may still take."""
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
