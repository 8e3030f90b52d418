"""The lexical pass before the grammar: comments, strings, and characters that mean nothing.

The grammar then reads a text of equal length in which comments and faulty characters are blanks, so
every offset stays what it was.
"""

from __future__ import annotations

import re
from dataclasses import dataclass

from robosc.errors import Diagnostic, Severity
from robosc.source import Source, Span

__all__ = ["MAX_FAULTS", "Comment", "Scan", "scan"]

_INTERESTING = re.compile(
    r"""
      (?P<line>//[^\n]*)
    | (?P<block>/\*.*?(?:\*/|\Z))
    | (?P<string>"[^"\\\n]*(?:\\[^\n][^"\\\n]*)*\\?"?|'[^'\\\n]*(?:\\[^\n][^'\\\n]*)*\\?'?)
    | (?P<hash>\#[^\n]*)
    | (?P<bad>[^ \t\r\n\w"'(){}\[\].,:=<>!+\-*/^]+)
    """,
    re.VERBOSE | re.DOTALL | re.ASCII,
)

MAX_FAULTS = 100
"""After so many errors a file gets one more that says so; a binary file would have a million."""

_ADVICE = {
    ";": "nothing stands between declarations",
    "&": "write 'and'",
    "|": "write 'or'",
    "#": "a comment begins with '//'",
    "~": "write '!' for 'not'",
    "\u00a0": "a plain space is meant",
    "\u201c": "a straight quote is meant",
    "\u201d": "a straight quote is meant",
    "\u2018": "a straight quote is meant",
    "\u2019": "a straight quote is meant",
    "\u2013": "a plain '-' is meant",
    "\u2212": "a plain '-' is meant",
    "\u2264": "write '<='",
    "\u2265": "write '>='",
    "\u2260": "write '!='",
}


@dataclass(frozen=True, slots=True)
class Comment:
    """A comment with its delimiters."""

    text: str
    start: int
    end: int


@dataclass(frozen=True, slots=True)
class Scan:
    """``text`` is the source with blanks for all that the grammar shall not see.

    ``faults`` are the places of all lexical faults in order; ``diagnostics`` tell of the first.
    ``open_end`` tells that an unterminated comment has swallowed the rest of the file. ``binary``
    tells that the file is no text at all.
    """

    text: str
    comments: tuple[Comment, ...]
    diagnostics: tuple[Diagnostic, ...]
    faults: tuple[int, ...]
    open_end: bool
    binary: bool = False


def scan(source: Source) -> Scan:
    """Find comments and lexical faults in one pass."""
    text = source.text
    if (nul := text.find("\0")) >= 0:
        fault = _error(source, "bad-character", nul, nul + 1, "the file contains a NUL character")
        return Scan("", (), (fault,), (nul,), False, binary=True)
    comments: list[Comment] = []
    diagnostics: list[Diagnostic] = []
    faults: list[int] = []
    done = 1 if text.startswith("\ufeff") else 0
    pieces = [" " * done]
    open_end = False
    for match in _INTERESTING.finditer(text, done):
        start, end = match.span()
        found = match.group()
        kind = match.lastgroup
        if kind == "string" and _terminated(found):
            continue
        if kind in ("line", "block"):
            comments.append(Comment(found, start, end))
            open_end = kind == "block" and (len(found) < 4 or not found.endswith("*/"))
        if kind in ("string", "hash", "bad") or open_end:
            faults.append(start)
            if len(faults) <= MAX_FAULTS + 1:
                diagnostics.append(_fault(source, kind or "", start, end))
        pieces += text[done:start], _blank(kind or "", found)
        done = end
    pieces.append(text[done:])
    return Scan("".join(pieces), tuple(comments), tuple(diagnostics), tuple(faults), open_end)


def _fault(source: Source, kind: str, start: int, end: int) -> Diagnostic:
    if kind == "hash":  # what follows is meant as a comment
        return _bad_character(source, start, start + 1)
    if kind == "bad":
        return _bad_character(source, start, end)
    if kind == "string":
        hint = f"close it with {source.text[start]}"
        return _error(source, "unterminated-string", start, end, "this string has no end", hint)
    message = "this comment has no end"
    return _error(source, "unterminated-comment", start, start + 2, message, "close it with */")


def _terminated(string: str) -> bool:
    if len(string) < 2 or string[-1] != string[0]:
        return False
    body = string[1:-1]
    return (len(body) - len(body.rstrip("\\"))) % 2 == 0


def _blank(kind: str, found: str) -> str:
    """What the grammar reads instead, of equal length: blanks, or a string where one was begun."""
    if kind == "string" and len(found) > 1:
        return found[0] + " " * (len(found) - 2) + found[0]
    return "\n".join(" " * len(line) for line in found.split("\n"))


def _bad_character(source: Source, start: int, end: int) -> Diagnostic:
    found = source.text[start:end]
    shown = found if found.isprintable() else " ".join(f"U+{ord(c):04X}" for c in found[:4])
    if len(shown) > 20:
        shown = shown[:20] + "…"
    if found.isalpha():
        hint: str | None = "names have the letters a-z and A-Z, digits and '_'"
    else:
        hint = _ADVICE.get(found[0])
    return _error(source, "bad-character", start, end, f"'{shown}' means nothing here", hint)


def _error(
    source: Source, code: str, start: int, end: int, message: str, hint: str | None = None
) -> Diagnostic:
    return Diagnostic(Severity.ERROR, code, message, Span(source, start, end), hint)
