"""Places in a text, as the protocol counts them.

The protocol counts lines from 0, and columns in units of an encoding, UTF-16 unless the client
wants another one; robosc counts characters.
"""

from __future__ import annotations

from typing import Literal, TypeAlias

from robosc.source import Source, Span

__all__ = ["Encoding", "Position", "Range", "offset_of", "position_of", "range_of", "units"]

Encoding: TypeAlias = Literal["utf-8", "utf-16", "utf-32"]
Position: TypeAlias = tuple[int, int]
Range: TypeAlias = tuple[Position, Position]

_UNIT = {"utf-8": 1, "utf-16": 2, "utf-32": 4}
_CODEC = {"utf-8": "utf-8", "utf-16": "utf-16-le", "utf-32": "utf-32-le"}


def position_of(source: Source, offset: int, encoding: Encoding = "utf-16") -> Position:
    """The place of a character offset."""
    line, column = source.position(offset)
    return line - 1, units(source.text[offset - column + 1 : offset], encoding)


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
