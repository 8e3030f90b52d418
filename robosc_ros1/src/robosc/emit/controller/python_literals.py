"""Data as Python source, as formatters lay it out: what fits on a line, else an entry on each."""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator
from typing import Any

from robosc.emit.write.line_breaks import INDENT, WIDTH, broken_string, quoted


def assignment(name: str, value: Any) -> str:
    """The statement that gives a name a value of dicts, lists, tuples and primitive values."""
    return "\n".join(_Layout().lines(f"{name} = ", value, "", "")) + "\n"


def literal(value: Any) -> str:
    """The value on one line."""
    text = _Layout().within(value, math.inf)
    assert text is not None
    return text


class _Layout:
    """Writes data."""

    def lines(self, head: str, value: Any, tail: str, indent: str) -> Iterator[str]:
        """Yield the lines of a value, with what stands before and behind it."""
        text = self.within(value, WIDTH - len(indent + head + tail))
        if text is not None:
            yield indent + head + text + tail
        elif isinstance(value, str) and value:
            parts = broken_string("", quoted(value), "", indent + INDENT)
            yield from (f"{indent}{head}(", *parts, f"{indent}){tail}")
        elif isinstance(value, dict) and value:
            yield f"{indent}{head}{{"
            for key, entry in value.items():
                yield from self.lines(f"{literal(key)}: ", entry, ",", indent + INDENT)
            yield f"{indent}}}{tail}"
        elif isinstance(value, list | tuple) and value:
            start, end = "[]" if isinstance(value, list) else "()"
            yield indent + head + start
            for entry in value:
                yield from self.lines("", entry, ",", indent + INDENT)
            yield indent + end + tail
        else:
            yield indent + head + literal(value) + tail

    def within(self, value: Any, room: float) -> str | None:
        """Return the value on one line, if it has not more characters than ``room``."""
        text: str | None
        if isinstance(value, str):
            text = quoted(value)
        elif isinstance(value, dict):
            text = self._joined((entry for pair in value.items() for entry in pair), "{}", room)
        elif isinstance(value, list | tuple):
            text = self._joined(value, "[]" if isinstance(value, list) else "()", room)
        elif isinstance(value, float) and not math.isfinite(value):
            text = f'float("{value}")'
        else:
            text = repr(value)
        return None if text is None or len(text) > room else text

    def _joined(self, entries: Iterable[Any], brackets: str, room: float) -> str | None:
        """Return entries in brackets; those of a dict are keys and values in turn."""
        parts: list[str] = []
        for entry in entries:
            text = self.within(entry, room)
            if text is None:
                return None
            room -= len(text) + 2
            parts.append(text)
        if brackets == "{}":
            parts = [f"{key}: {value}" for key, value in zip(parts[::2], parts[1::2], strict=True)]
        comma = "," * (brackets == "()" and len(parts) == 1)
        return f"{brackets[0]}{', '.join(parts)}{comma}{brackets[1]}"
