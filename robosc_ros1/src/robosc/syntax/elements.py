"""What the grammar is made of beyond pyparsing's own elements, and the text that they read.

pyparsing hands the text to every element. Ours is a :class:`ModelText`: it carries the source and
collects the faults, so that the grammar itself is built once and holds no state.
"""

from __future__ import annotations

import re
from bisect import bisect_left, bisect_right
from collections.abc import Callable
from difflib import get_close_matches
from typing import Any, TypeAlias

from pyparsing import (
    ParseBaseException,
    ParseElementEnhance,
    ParseException,
    ParserElement,
    ParseSyntaxException,
    Token,
)

from robosc.errors import Diagnostic, Note, Severity
from robosc.source import Source, Span
from robosc.syntax.keywords import is_declaration
from robosc.syntax.nodes import FileNode
from robosc.syntax.scan import MAX_FAULTS, Scan

__all__ = ["Build", "Built", "Fault", "ModelText", "Nested", "Terminal", "skip_space", "text_of"]

_SPACE = re.compile(r"[ \t\r\n]*")
_LEXEME = re.compile(
    r"\^?\w+|\d+(?:\.\d+)?|\"[^\"\n]*\"?|'[^'\n]*'?|[=!<>:]=|=>|->|\.\.|.", re.ASCII
)
_WORD = re.compile(r"[A-Za-z_]\w*", re.ASCII)
_STATEMENTS = frozenset({"requirement", "provide", "on", "transition"})
_DECLARING = frozenset(
    {"component", "datatype", "interface", "message", "service", "action", "variable", "state"}
)
_INSIDE = ("expected a value after", "expected an operator")
_ENDING = re.compile(r"(?:\w+|[=!<>]+|.)\Z", re.ASCII | re.DOTALL)
_LOOK_BACK = 100
_QUOTED = re.compile(r"'(\w+)")
_ADVICE = {
    "not": "write '!' for 'not'",
    "and": "write '^and' if this is a name",
    "or": "write '^or' if this is a name",
    "true": "write '^true' if this is a name",
    "false": "write '^false' if this is a name",
    ".": "a number begins with a digit, as in 0.5",
}


class Fault(ParseSyntaxException):
    """A fault that needs more than "expected …": its own code, extent or hint."""

    def __init__(
        self,
        text: str,
        start: int,
        message: str,
        *,
        end: int | None = None,
        code: str = "syntax",
        hint: str | None = None,
    ) -> None:
        super().__init__(text, start, message)
        self.end = end
        self.code = code
        self.hint = hint


class ModelText(str):
    """The scanned text of one source, and what one parse finds in it.

    ``item_start`` is where the declaration begins that is being read; ``depth`` counts the levels
    of the construct that nests just now; ``settled`` is a place whose fault is already told: what
    goes wrong exactly there is its consequence. ``reopened`` tells that a block was continued
    behind its closing brace, so that the braces no longer count. ``broken`` collects the words of
    everything that was skipped: names that later stages must not call unknown. ``lifted`` holds,
    by block, nodes of declarations that stood in a block inside it.
    """

    source: Source
    scan: Scan
    diagnostics: list[Diagnostic]
    broken: set[str]
    lifted: dict[Any, list[Any]]
    tree: FileNode | None
    item_start: int
    depth: int
    settled: int
    reopened: bool
    body_end: int

    @classmethod
    def of(cls, source: Source, scan: Scan) -> ModelText:
        self = cls(scan.text)
        self.source = source
        self.scan = scan
        self.diagnostics = list(scan.diagnostics)
        self.broken = set()
        self.lifted = {}
        self.tree = None
        self.item_start = self.depth = 0
        self.settled = -1
        self.reopened = False
        self.body_end = len(scan.text.rstrip())
        return self

    def report(
        self,
        code: str,
        message: str,
        start: int,
        end: int | None = None,
        hint: str | None = None,
        notes: tuple[Note, ...] = (),
    ) -> None:
        """Add an error; without ``end`` it spans the lexeme at ``start``."""
        start = skip_space(self, start)
        if start >= self.body_end:
            # The file ends too early: point right behind its last character.
            start = end = self.body_end
            message += ", but the file ends here"
        elif end is None:
            lexeme = _LEXEME.match(self, start)
            end = lexeme.end() if lexeme else start + 1
        span = Span(self.source, start, end)
        self.diagnostics.append(Diagnostic(Severity.ERROR, code, message, span, hint, notes))

    def report_fault(self, start: int, resume: int, fault: ParseBaseException) -> None:
        """Add what went wrong in the declaration that begins at ``start``.

        Nothing is added where a lexical fault in ``start..resume`` explains it, or, at the end of
        the file, a comment that was never closed.
        """
        at = skip_space(self, fault.loc)
        if self.has_lexical_fault(start, max(resume, at + 1)):
            return
        if at >= self.body_end:
            if self.scan.open_end or self.settled >= self.body_end:
                return
            self.settled = self.body_end
        message = fault.msg[:1].lower() + fault.msg[1:]
        before = self.trimmed(at)
        if message.startswith(_INSIDE) and "\n" in self[before:at]:
            # An expression breaks off at the end of its line: what comes next is not to blame.
            ending = _ENDING.search(self[max(0, before - _LOOK_BACK) : before])
            begin = ending.start() + max(0, before - _LOOK_BACK) if ending else before
            hint = fault.hint if isinstance(fault, Fault) else None
            self.report("syntax", message, begin, before, hint)
        elif isinstance(fault, Fault):
            self.report(fault.code, message, at, fault.end, fault.hint)
        else:
            self.report("syntax", message, at, hint=_hint(self, at, message))

    def skipped(self, start: int, end: int) -> None:
        """Remember the words of a declaration that will not be in the tree.

        A statement or transition declares nothing, so that unknown names elsewhere stay unknown.
        """
        words = _WORD.findall(self[start:end])
        if words and words[0] in _STATEMENTS and _DECLARING.isdisjoint(words):
            return
        self.broken.update(words)

    @property
    def exhausted(self) -> bool:
        """There are so many errors that reading on helps nobody."""
        return len(self.diagnostics) > MAX_FAULTS

    def has_lexical_fault(self, start: int, end: int) -> bool:
        faults = self.scan.faults
        index = bisect_left(faults, start)
        return index < len(faults) and faults[index] < end

    def follows_lexical_fault(self, loc: int) -> bool:
        """Is what stands right before ``loc`` a lexical fault?"""
        index = bisect_right(self.scan.faults, loc) - 1
        return index >= 0 and not self[self.scan.faults[index] : loc].strip()

    def trimmed(self, end: int) -> int:
        """The end of what was read: optional parts that are absent skip the blanks before them."""
        while self[end - 1] in " \t\r\n":
            end -= 1
        return end

    def span(self, start: int, end: int) -> Span:
        return Span(self.source, start, end)


Build: TypeAlias = Callable[[ModelText, int, int, list[Any]], Any]
"""Makes a node from the text, its extent, and the values of its parts."""


def text_of(instring: str) -> ModelText:
    assert isinstance(instring, ModelText)
    return instring


def skip_space(text: str, loc: int) -> int:
    match = _SPACE.match(text, loc)
    return match.end() if match else loc


def _hint(text: str, at: int, message: str) -> str | None:
    """The remedy, where what was found shows what was meant."""
    lexeme = _LEXEME.match(text, at)
    if lexeme is None:
        return None
    found = lexeme.group()
    if found == "=" and message.startswith("expected ':='"):
        return "write ':=' to assign"
    if found == "," and message.startswith("expected 'needs'"):
        return "several stand in braces: { …, … }"
    if found in _ADVICE:
        return _ADVICE[found]
    if f"'{found}:'" in message:
        colon = text.startswith(":", skip_space(text, lexeme.end()))
        if not colon:
            return f"write '{found}:' with its colon"
        missing = "'with'" if message.startswith("expected 'with'") else "a ','"
        return f"{missing} is missing before it"
    near = get_close_matches(found, _QUOTED.findall(message), 1, 0.6) if len(found) < 30 else []
    return f"did you mean '{near[0]}'?" if near and near[0] != found else None


class Terminal(Token):
    """One token, given as a regular expression.

    ``build`` makes its value from the matched text and its extent; without it the token leaves
    nothing behind, as keywords and punctuation do. ``is_name`` refuses a word that begins the next
    declaration.
    """

    def __init__(
        self,
        pattern: str,
        expected: str,
        build: Callable[[ModelText, int, int, str], Any] | None = None,
        *,
        is_name: bool = False,
    ) -> None:
        super().__init__()
        self._match = re.compile(pattern, re.ASCII).match
        self._expected = expected
        self._build = build
        self._is_name = is_name
        self.errmsg = f"expected {expected}"
        self.mayIndexError = False

    def _generateDefaultName(self) -> str:
        return self._expected

    def parseImpl(self, instring: str, loc: int, do_actions: bool = True) -> Any:
        match = self._match(instring, loc)
        if match is None or (self._is_name and is_declaration(instring, loc, match.group())):
            raise ParseException(instring, loc, self.errmsg, self)
        end = match.end()
        if self._build is None:
            return end, []
        return end, [self._build(text_of(instring), loc, end, match.group())]


class Built(ParseElementEnhance):
    """A rule whose parts become one node."""

    def __init__(self, expr: ParserElement, build: Build) -> None:
        super().__init__(expr)
        self._build = build
        self.mayIndexError = False

    def parseImpl(self, instring: str, loc: int, do_actions: bool = True) -> Any:
        end, parts = self.expr._parse(instring, loc, do_actions, False)
        text = text_of(instring)
        return end, [self._build(text, loc, text.trimmed(end), list(parts))]


class Nested(ParseElementEnhance):
    """A rule that contains itself, down to a limit: the text must not exhaust the stack."""

    def __init__(self, expr: ParserElement, limit: int, what: str) -> None:
        super().__init__(expr)
        self._limit = limit
        self._what = what

    def parseImpl(self, instring: str, loc: int, do_actions: bool = True) -> Any:
        text = text_of(instring)
        if text.depth >= self._limit:
            message = f"{self._what} nested more than {self._limit} deep"
            raise Fault(text, loc, message, code="too-deep")
        text.depth += 1
        try:
            return self.expr._parse(instring, loc, do_actions, False)
        finally:
            text.depth -= 1
