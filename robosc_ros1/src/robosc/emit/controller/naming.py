"""Names in generated code: unique, legal in Python, and close to what the user wrote."""

from __future__ import annotations

import builtins
import keyword
from collections.abc import Iterable

# Keywords that came after Python 3.8 or are about to come ("match" may stay a name).
_WORDS = frozenset(keyword.kwlist) | frozenset(dir(builtins))


class PythonNames:
    """Hands out identifiers, each once: a taken or reserved one gets a number behind it, and dots
    and spaces become underscores."""

    def __init__(self, reserved: Iterable[str] = ()) -> None:
        self._taken = set(_WORDS) | set(reserved)

    def take(self, wish: str) -> str:
        wish = wish.replace(".", "_").replace(" ", "_")
        name = wish if wish.isidentifier() else f"n_{wish}"
        if name in _WORDS:
            name += "_"
        candidate, number = name, 2
        while candidate in self._taken:
            candidate, number = f"{name}_{number}", number + 1
        self._taken.add(candidate)
        return candidate


def field_attribute(name: str) -> str:
    """A message's field as an attribute in Python: genpy puts ``_`` behind a keyword."""
    return f"{name}_" if keyword.iskeyword(name) else name
