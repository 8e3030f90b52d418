"""Pretty printing: documents with possible line breaks, and the printer that decides on them.

After Philip Wadler, *A prettier printer* (2003): a group is printed on one line if it fits, else
all of its own breaks become line ends, and the groups inside it are tried again.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import TypeAlias

from robosc.lazy_dataclasses import dataclass


@dataclass(frozen=True, slots=True)
class Line:
    """A possible line break: taken if ``hard``, or if its group is broken.

    If it is not taken, ``flat`` is printed in its place. ``blank`` adds an empty line.
    """

    flat: str = " "
    hard: bool = False
    blank: bool = False


@dataclass(frozen=True, slots=True)
class Remark:
    """A comment, on a line of its own or behind other text.

    ``column`` (from 0) is where it began in the text, so that the further lines of a long comment
    are shifted with the first.
    """

    text: str
    own_line: bool
    column: int

    @property
    def ends_line(self) -> bool:
        return self.own_line or self.text.startswith("//")


@dataclass(frozen=True, slots=True)
class Indent:
    """A document whose lines are indented by one more step."""

    inside: Sequence[Doc]


@dataclass(frozen=True, slots=True)
class Group:
    """A document of which all line breaks are taken, or none; ``broken`` requires all."""

    inside: Sequence[Doc]
    broken: bool = False


Doc: TypeAlias = "str | Line | Remark | Indent | Group | list[Doc]"
_Task: TypeAlias = tuple[int, bool, Doc]
"""A document still to be printed: its indentation, whether its group is flat, the document."""

_STEP = 4


class _Printer:
    """The state of printing; blanks and line ends are delayed until text follows them."""

    def __init__(self, width: int) -> None:
        self.width = width
        self.pieces: list[str] = []
        self.column = 0
        self.line_ends = 0
        self.indent: int | None = None
        self.space = False

    def run(self, doc: Doc) -> str:
        tasks: list[_Task] = [(0, False, doc)]
        while tasks:
            indent, flat, now = tasks.pop()
            if type(now) is str:  # by far the most frequent
                if now == " ":
                    self.space = True
                else:
                    self._write(now, indent)
                continue
            match now:
                case Remark():
                    self._remark(now, indent)
                case Line(hard=hard, blank=blank):
                    if hard or not flat:
                        self._end_line(indent, blank)
                    elif now.flat:
                        self.space = True
                case Indent(inside=inside):
                    tasks += [(indent + _STEP, flat, part) for part in reversed(inside)]
                case Group(inside=inside, broken=broken):
                    flat = not broken and (flat or self._fits(inside, indent, tasks))
                    tasks += [(indent, flat, part) for part in reversed(inside)]
                case list():
                    tasks += [(indent, flat, part) for part in reversed(now)]
        return "".join(self.pieces) + "\n"

    def _end_line(self, indent: int | None, blank: bool = False) -> None:
        """Begin the next text on a new line, indented by ``indent``, or as its own task says."""
        self.line_ends = max(self.line_ends, 2 if blank else 1)
        self.indent = indent

    def _write(self, text: str, indent: int) -> None:
        if self.line_ends and self.pieces:
            self.column = indent if self.indent is None else self.indent
            self.pieces.append("\n" * self.line_ends + " " * self.column)
        elif self.space and self.pieces:
            self.pieces.append(" ")
            self.column += 1
        self.line_ends, self.space = 0, False
        self.pieces.append(text)
        self.column += len(text)

    def _remark(self, remark: Remark, indent: int) -> None:
        if remark.own_line and not self.line_ends:
            self._end_line(None)
        self.space = True
        first, *others = remark.text.split("\n")
        self._write(first.rstrip(), indent)
        if others:
            shift = self.column - len(first.rstrip()) - remark.column
            others = _shifted([line.rstrip() for line in others], shift)
            self.pieces.append("\n" + "\n".join(others))
            self.column = len(others[-1])
        if remark.ends_line:
            self._end_line(None)
        else:
            self.space = True

    def _fits(self, inside: Sequence[Doc], indent: int, rest: list[_Task]) -> bool:
        """Whether it fits on the rest of this line, with what follows up to a line break."""
        start = self.column + self.space
        if self.line_ends:
            start = indent if self.indent is None else self.indent
        left = self.width - start
        tasks: list[_Task] = [(indent, True, part) for part in reversed(inside)]
        following = len(rest)
        while left >= 0:
            if not tasks:
                if following == 0:
                    return True
                following -= 1
                tasks.append(rest[following])
                continue
            indent, flat, now = tasks.pop()
            if type(now) is str:
                left -= len(now)
                continue
            match now:
                case Remark(text=text):
                    if now.ends_line:
                        return True
                    first, *others = text.split("\n")
                    left -= 1 + len(first)
                    if others:
                        return left >= 0
                case Line(hard=hard):
                    if hard or not flat:
                        return True
                    left -= len(now.flat)
                case Indent(inside=parts):
                    tasks += [(indent, flat, part) for part in reversed(parts)]
                case Group(inside=parts, broken=broken):
                    tasks += [(indent, flat and not broken, part) for part in reversed(parts)]
                case list():
                    tasks += [(indent, flat, part) for part in reversed(now)]
        return False


def _shifted(lines: list[str], shift: int) -> list[str]:
    """The lines shifted to the right or left; unchanged if one has too little indentation."""
    if shift >= 0:
        return [" " * shift + line if line else "" for line in lines]
    room = min((len(line) - len(line.lstrip(" ")) for line in lines if line), default=0)
    return [line[-shift:] for line in lines] if room >= -shift else lines


def print_doc(doc: Doc, width: int) -> str:
    """The text of a document, with lines of at most ``width`` columns where breaks allow it."""
    return _Printer(width).run(doc)
