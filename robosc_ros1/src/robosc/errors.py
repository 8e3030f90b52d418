"""What robosc reports to its users: diagnostics of a model, and the ways a command can fail.

A fault in a model is a :class:`Diagnostic`; stages collect them and go on. Everything that ends a
command is a :class:`RoboscError` with its exit code. Any other exception is a bug in
robosc and shows a traceback.
"""

from __future__ import annotations

import re
from collections.abc import Iterable, Sequence
from dataclasses import replace
from enum import Enum

from robosc import limits, remedies, source
from robosc.lazy_dataclasses import dataclass


class Severity(Enum):
    ERROR = "error"
    WARNING = "warning"


@dataclass(frozen=True, slots=True)
class Note:
    """A second place that helps to understand a diagnostic; ``span`` is None for words alone."""

    message: str
    span: source.Span | None = None


@dataclass(frozen=True, slots=True)
class Diagnostic:
    """One fault in a model, in the user's words.

    ``code`` is stable and documented in ``docs/diagnostics.md``; ``advice`` is the remedy, short
    enough to stand behind the caret.
    """

    severity: Severity
    code: str
    message: str
    span: source.Span
    advice: remedies.Hint | None = None
    notes: tuple[Note, ...] = ()

    @property
    def hint(self) -> str | None:
        """The words of the remedy."""
        return self.advice.text if isinstance(self.advice, remedies.Remedy) else self.advice

    @property
    def remedy(self) -> remedies.Remedy | None:
        """The remedy, if an editor can carry it out."""
        return self.advice if isinstance(self.advice, remedies.Remedy) else None


class RoboscError(Exception):
    """A failure that the user can cause and mend; ``exit_code`` is the process's."""

    exit_code = 1


class ModelError(RoboscError):
    """The model has errors; all of them are in ``diagnostics`` (warnings included)."""

    def __init__(self, diagnostics: Sequence[Diagnostic]) -> None:
        super().__init__(f"{len(diagnostics)} diagnostics")
        self.diagnostics = tuple(diagnostics)

    def __str__(self) -> str:
        return "\n" + render_all(self.diagnostics)


class UsageError(RoboscError):
    """Wrong arguments, an unreadable file, a target folder in the way."""

    exit_code = 2


class EmptySupervisorError(RoboscError):
    """No controller can satisfy the requirements; ``diagnostics`` say why."""

    exit_code = 3

    def __init__(self, message: str, diagnostics: Sequence[Diagnostic] = ()) -> None:
        super().__init__(message)
        self.diagnostics = tuple(diagnostics)


class StateSpaceError(RoboscError):
    """The state space is too large for the chosen engine and limits, or for the memory."""

    exit_code = 4


OUT_OF_MEMORY = "this takes more memory than there is, or than 'ulimit -v' allows"
"""The message where Python could not get the memory that it asked for."""


def counted(number: int, noun: str, ending: str = "s") -> str:
    """``1 state``, ``2 states``."""
    return f"{number:,} {noun}{ending * (number != 1)}"


def listing(phrases: Iterable[str], last: str = "and") -> str:
    """The phrases as a list in English: ``a``, ``a and b``, ``a, b and c``; empty if none."""
    *others, final = [*phrases] or [""]
    return f"{', '.join(others)} {last} {final}" if others else final


def has_errors(diagnostics: Iterable[Diagnostic]) -> bool:
    return any(d.severity is Severity.ERROR for d in diagnostics)


def sort_diagnostics(diagnostics: Iterable[Diagnostic]) -> list[Diagnostic]:
    """In reading order, each once, and once for all copies of a component or statement."""
    found: dict[tuple[object, ...], list[Diagnostic]] = {}
    for diagnostic in dict.fromkeys(diagnostics):
        # Copies may come to the same by other traces: what the diagnostic says stands before them.
        alike = _INDEX.sub("", diagnostic.message.partition(": after ")[0])
        key = diagnostic.code, diagnostic.span, diagnostic.severity, alike
        found.setdefault(key, []).append(diagnostic)
    unique = [_for_all(alike) for alike in found.values()]
    return sorted(unique, key=lambda d: (d.span.source.path, d.span.start, d.span.end, d.code))


def at_most(diagnostics: list[Diagnostic], most: int) -> list[Diagnostic]:
    """The diagnostics up to so many errors, with one in the place of all that follow these."""
    errors = [place for place, one in enumerate(diagnostics) if one.severity is Severity.ERROR]
    if len(errors) <= most:
        return diagnostics
    message = f"there are more than {most} errors: the others are not shown"
    last = Diagnostic(Severity.ERROR, "too-many-errors", message, diagnostics[errors[most]].span)
    return [*diagnostics[: errors[most]], last]


_INDEX = re.compile(r"\[-?\d+\]|\([A-Za-z_]\w* = -?\d+(?:, [A-Za-z_]\w* = -?\d+)*\)", re.ASCII)
"""What distinguishes copies: ``Station[3]``, or ``(i = 3)`` behind a statement."""


def _for_all(alike: list[Diagnostic]) -> Diagnostic:
    """One diagnostic for several that differ in their indexes only."""
    first, *others = alike
    if not others:
        return first
    return replace(first, message=f"{first.message}; the same for {len(others)} more")


_STYLES = {"error": "\x1b[1;31m", "warning": "\x1b[1;33m", "caret": "\x1b[1;36m"}
_RESET = "\x1b[0m"


def render(diagnostic: Diagnostic, color: bool = False) -> str:
    """Place, severity, code and message, then the line with a caret under the exact span."""

    def paint(style: str, text: str) -> str:
        return f"{_STYLES[style]}{text}{_RESET}" if color else text

    severity = diagnostic.severity.value
    head = (
        f"{_place(diagnostic.span)}: {paint(severity, f'{severity}[{diagnostic.code}]')}:"
        f" {diagnostic.message}"
    )
    line, room, carets = _excerpt(diagnostic.span)
    lines = [head, line, room + paint("caret", carets)]
    hint = diagnostic.hint or ""
    if "\n" in hint:
        lines += ("     = " + part if part else "" for part in hint.split("\n"))
    elif hint:
        lines[-1] += f" {hint}"
    for note in diagnostic.notes:
        where = f"{_place(note.span)}: " if note.span else "     = "
        lines.append(f"{where}note: {note.message}")
    return "\n".join(lines)


def render_all(diagnostics: Iterable[Diagnostic], color: bool = False) -> str:
    """All diagnostics in reading order, a line end behind each."""
    return "".join(render(d, color) + "\n" for d in sort_diagnostics(diagnostics))


def _place(span: source.Span) -> str:
    return f"{span.source.path}:{span.line}:{span.column}"


def _excerpt(span: source.Span) -> tuple[str, str, str]:
    """The source line with its number, the white space that leads up to the carets, and these.

    Tabs stay tabs in the lead so that the caret stands under its character in any terminal; a very
    long line is cut to the part around the span.
    """
    text = span.source.line(span.line)
    start = span.column - 1
    end = span.end_column - 1 if span.end_line == span.line else len(text)
    if len(text) > limits.SHOWN_COLUMNS:
        cut = max(0, min(start - limits.SHOWN_COLUMNS // 4, len(text) - limits.SHOWN_COLUMNS))
        text = text[cut : cut + limits.SHOWN_COLUMNS]
        start, end = start - cut, min(end - cut, limits.SHOWN_COLUMNS)
    text = "".join(c if c == "\t" or c.isprintable() else "�" for c in text)
    lead = "".join(c if c == "\t" else " " for c in text[:start])
    number = f"{span.line:5} | "
    width = max(1, end - start)
    return number + text, " " * (len(number) - 2) + "| " + lead, "^" * width
