"""Data as Python source, as formatters lay it out: what fits on a line, else an entry on each."""

from __future__ import annotations

import math
from collections.abc import Iterator
from typing import Any

from robosc.emit.write.line_breaks import INDENT, WIDTH, broken_string, quoted


def assignment(name: str, value: Any) -> str:
    """The statement that gives a name a value of dicts, lists, tuples and primitive values."""
    return "\n".join(_lines(f"{name} = ", value, "", "")) + "\n"


def _lines(head: str, value: Any, tail: str, indent: str) -> Iterator[str]:
    text = literal(value)
    if len(indent + head + text + tail) <= WIDTH or not value:
        yield indent + head + text + tail
    elif isinstance(value, str):
        parts = broken_string("", text, "", indent + INDENT)
        yield from (f"{indent}{head}(", *parts, f"{indent}){tail}")
    elif isinstance(value, dict):
        yield f"{indent}{head}{{"
        for key, entry in value.items():
            yield from _lines(f"{literal(key)}: ", entry, ",", indent + INDENT)
        yield f"{indent}}}{tail}"
    elif isinstance(value, list | tuple):
        start, end = "[]" if isinstance(value, list) else "()"
        yield indent + head + start
        for entry in value:
            yield from _lines("", entry, ",", indent + INDENT)
        yield indent + end + tail
    else:
        yield indent + head + text + tail


def literal(value: Any) -> str:
    """The value on one line."""
    if isinstance(value, str):
        return quoted(value)
    if isinstance(value, dict):
        return f"{{{', '.join(f'{literal(k)}: {literal(v)}' for k, v in value.items())}}}"
    if isinstance(value, list):
        return f"[{', '.join(map(literal, value))}]"
    if isinstance(value, tuple):
        return f"({', '.join(map(literal, value))}{',' * (len(value) == 1)})"
    if isinstance(value, float) and not math.isfinite(value):
        return f'float("{value}")'
    return repr(value)
