"""Model text and places in it.

Every later stage points at the user's text through a :class:`Span`; nothing but this module counts
lines and columns.
"""

from __future__ import annotations

import re
import sys
from bisect import bisect_left, bisect_right
from contextlib import AbstractContextManager, nullcontext
from dataclasses import field
from functools import cached_property
from pathlib import Path
from typing import BinaryIO

from robosc.lazy_dataclasses import dataclass

MODEL_SUFFIXES = (".rscd", ".rsc")
"""The ends of the names of model files; the second is that of the original tool."""


def opened(path: str) -> AbstractContextManager[BinaryIO]:
    """Open a file that the user has named; ``-`` is standard input."""
    return nullcontext(sys.stdin.buffer) if path == "-" else Path(path).open("rb")


@dataclass(frozen=True, eq=False)
class Source:
    """One model file: its path as the user gave it, and its text with line ends made ``\\n``."""

    path: str
    text: str

    @property
    def file_name(self) -> str:
        """The file's name without its folder, so that output does not depend on where it lies."""
        return Path(self.path).name

    @cached_property
    def _line_starts(self) -> list[int]:
        return [0, *(match.end() for match in re.finditer("\n", self.text))]

    @cached_property
    def sha256(self) -> str:
        """That of the text, as hexadecimal digits."""
        from hashlib import sha256  # loads OpenSSL

        return sha256(self.text.encode("utf-8", "surrogatepass")).hexdigest()

    def position(self, offset: int) -> tuple[int, int]:
        """Line and column, both from 1, of a character offset."""
        line = bisect_right(self._line_starts, offset)
        return line, offset - self._line_starts[line - 1] + 1

    def line_start(self, number: int) -> int:
        """Offset of the first character of a line (from 1); the text's end past the last one."""
        starts = self._line_starts
        return starts[number - 1] if number <= len(starts) else len(self.text)

    def line(self, number: int) -> str:
        """Text of a line (from 1) without its line end; empty past the last one."""
        return self.text[self.line_start(number) : self.line_start(number + 1)].removesuffix("\n")


@dataclass(frozen=True, slots=True)
class Span:
    """A half-open range of character offsets in one source."""

    source: Source = field(repr=False)
    start: int
    end: int

    @property
    def line(self) -> int:
        return self.source.position(self.start)[0]

    @property
    def column(self) -> int:
        return self.source.position(self.start)[1]

    @property
    def end_line(self) -> int:
        return self.source.position(self.end)[0]

    @property
    def end_column(self) -> int:
        return self.source.position(self.end)[1]

    @property
    def text(self) -> str:
        return self.source.text[self.start : self.end]

    @property
    def place(self) -> str:
        """Where it begins: ``line_follower.rscd:42``."""
        return f"{self.source.file_name}:{self.line}"

    def told_from(self, other: Span) -> str:
        """The line, as it is told in the source of another span: ``line 42``, or its place if that
        is in a different file."""
        return f"line {self.line}" if self.source is other.source else self.place

    def to(self, other: Span) -> Span:
        """The range from the start of this span to the end of another in the same source."""
        return Span(self.source, self.start, other.end)


def common_ends(one: str, other: str) -> tuple[int, int]:
    """How many characters two texts begin with alike, and with how many of the others they end."""
    lengths = range(1, min(len(one), len(other)) + 1)
    head = bisect_left(lengths, True, key=lambda n: not one.startswith(other[:n]))
    lengths = lengths[: len(lengths) - head]
    tail = bisect_left(lengths, True, key=lambda n: not one.endswith(other[-n:]))
    return head, tail
