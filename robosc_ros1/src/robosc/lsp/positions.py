"""Places in a text, as the protocol counts them.

The protocol counts lines from 0, and columns in units of an encoding, UTF-16 unless the client
wants another one; robosc counts characters.
"""

from __future__ import annotations

from functools import lru_cache
from itertools import accumulate
from typing import Literal, TypeAlias

from robosc.source import Source, Span

Encoding: TypeAlias = Literal["utf-8", "utf-16", "utf-32"]
Position: TypeAlias = tuple[int, int]
Range: TypeAlias = tuple[Position, Position]

_UNIT = {"utf-8": 1, "utf-16": 2, "utf-32": 4}
_LONG = 1000
"""Characters: in a longer line places are counted from the last multiple of it."""
_CODEC = {"utf-8": "utf-8", "utf-16": "utf-16-le", "utf-32": "utf-32-le"}


def position_of(source: Source, offset: int, encoding: Encoding = "utf-16") -> Position:
    """The place of a character offset."""
    line, column = source.position(offset)
    start = offset - column + 1
    if column <= _LONG:
        return line - 1, units(source.text[start:offset], encoding)
    mark, rest = divmod(column - 1, _LONG)
    before = _units_before(source, line, encoding)[mark]
    return line - 1, before + units(source.text[offset - rest : offset], encoding)


@lru_cache(maxsize=8)
def _units_before(source: Source, line: int, encoding: Encoding) -> list[int]:
    """The units in a line (from 1) before each multiple of :data:`_LONG` characters."""
    start = source.line_start(line)
    text = source.text[start : source.line_start(line + 1)]
    parts = (units(text[at : at + _LONG], encoding) for at in range(0, len(text), _LONG))
    return list(accumulate(parts, initial=0))


def range_of(span: Span, encoding: Encoding = "utf-16") -> Range:
    return (
        position_of(span.source, span.start, encoding),
        position_of(span.source, span.end, encoding),
    )


def offset_of(source: Source, position: Position, encoding: Encoding = "utf-16") -> int:
    """The character offset of a place; one past the end of its line, or the text, is that end."""
    number, units = position
    start = source.line_start(number + 1)
    line = source.line(number + 1)
    if units <= 0 or start >= len(source.text):
        return min(start, len(source.text))
    if line.isascii():
        return start + min(units, len(line))
    encoded = line.encode(_CODEC[encoding], "surrogatepass")[: units * _UNIT[encoding]]
    return start + len(encoded.decode(_CODEC[encoding], "ignore"))


def units(text: str, encoding: Encoding) -> int:
    """The length of a text as the protocol counts it."""
    if text.isascii():
        return len(text)
    return len(text.encode(_CODEC[encoding], "surrogatepass")) // _UNIT[encoding]
