"""The state of one parse: its tokens, the syntax errors found so far, and how they are reported.

The grammar itself is a constant without state.
"""

from __future__ import annotations

import re
from collections.abc import Callable
from functools import lru_cache
from typing import Any, TypeAlias

from pyparsing import ParseBaseException, ParserElement, ParseSyntaxException

from robosc import limits, remedies, source
from robosc.errors import Diagnostic, Note, Severity
from robosc.language.tokens import BAD_NUMBER, Tokens, is_word
from robosc.lazy_dataclasses import dataclass
from robosc.syntax.pyparsing_names import parse_string
from robosc.syntax.recovery.advice import advice

_STATEMENTS = frozenset({"requirement", "provide", "on", "transition"})
_DECLARING = frozenset(
    {"component", "datatype", "interface", "message", "service", "action", "variable", "state"}
)
_MEASURED = re.compile(r"(\d+(?:\.\d+)?)(?:m|cm|mm|km|deg|rad|Hz|kg|V)")
_INSIDE = ("expected a value after", "expected an operator")
_WINDOW = 64
_LOOKAHEAD = 8
"""The greatest lookahead of any rule of the grammar, in tokens."""


class Fault(Exception):
    """A syntax error in the declaration that is being parsed.

    ``at`` is the token where it begins, ``span`` its range if that is not this token.
    """

    def __init__(
        self,
        at: int,
        message: str,
        *,
        span: source.Span | None = None,
        code: str = "syntax",
        hint: remedies.Hint | None = None,
    ) -> None:
        super().__init__(message)
        self.at = at
        self.message = message
        self.span = span
        self.code = code
        self.hint = hint


class Stop(ParseSyntaxException):
    """A syntax error found by the grammar whose message is not "expected …".

    ``opened`` is the token of the bracket that the message is about.
    """

    def __init__(
        self,
        kinds: str,
        at: int,
        message: str,
        *,
        code: str = "syntax",
        hint: remedies.Hint | None = None,
        opened: int | None = None,
    ) -> None:
        super().__init__(kinds, at, message)
        self.code = code
        self.hint = hint
        self.opened = opened


@dataclass(frozen=True, slots=True)
class Form:
    """A match of a rule: its range of tokens, its parts, and the function that builds its node.

    The grammar matches kinds of tokens only. Once a declaration has matched,
    :meth:`ParseState.made` turns its forms into nodes.
    """

    build: Build
    start: int
    end: int
    parts: list[Any]


@dataclass(frozen=True, slots=True)
class _Applied:
    """The result of a rule on a window of tokens: its parts, and where it ends or fails."""

    parts: tuple[Any, ...]
    end: int
    fault: ParseBaseException | None = None


@lru_cache(maxsize=2**14)
def _applied(grammar: ParserElement, kinds: str) -> _Applied:
    """The result of a rule at the beginning of some tokens.

    Cached, since only their kinds count: an editor parses a text after each key, the formatter
    parses it twice, and most declarations have the kinds of others.
    """
    try:
        *parts, end = parse_string(grammar, kinds)
    except ParseBaseException as error:
        # The traceback would keep every frame of the parse alive.
        return _Applied((), error.loc, error.with_traceback(None))
    return _Applied(tuple(part for part in parts if type(part) is not str), end)


class ParseState:
    """The tokens of one source, and the state of one parse of them.

    ``reported_at`` is a token whose fault is already reported: another fault at that token is its
    consequence. ``reopened`` means that a block was continued behind its closing brace, so that
    missing braces are no longer reported. ``broken`` collects the words of everything that was
    skipped: names that later stages must not report as unknown. ``lifted`` holds, by block, nodes
    of its declarations that stood in a block inside it. ``depth`` counts the open blocks;
    ``is_balanced``: the text has as many closing braces as opening ones.
    """

    def __init__(self, tokens: Tokens) -> None:
        self.tokens = tokens
        self.kinds = tokens.kinds
        self.is_balanced = tokens.kinds.count("{") == tokens.kinds.count("}")
        self.source = tokens.source
        self.diagnostics: list[Diagnostic] = list(tokens.diagnostics)
        self.broken: set[str] = set()
        self.lifted: dict[Any, list[Any]] = {}
        self.depth = 0
        self.reported_at = -1
        self.reopened = False

    def text(self, index: int) -> str:
        return self.tokens.text(index)

    def span(self, start: int, end: int) -> source.Span:
        return self.tokens.span(start, end)

    def kind(self, index: int) -> str:
        """The kind of a token; empty behind the last one."""
        return self.kinds[index : index + 1]

    # --- parsing ---

    def parse(self, grammar: ParserElement, at: int) -> tuple[list[Any], int]:
        """Apply a rule to the tokens from ``at`` on; its parts as nodes, and the token behind it.

        The rule is given a window of the tokens, and a larger one if it has come near its end.

        Raises:
            Fault: the tokens do not match, or what they stand for is faulty.
        """
        size = _WINDOW
        while True:
            found = _applied(grammar, self.kinds[at : at + size])
            if found.end + _LOOKAHEAD < size or at + size >= len(self.kinds):
                break
            size *= 8
        if found.fault:
            raise self._explained(found.fault, at)
        return [self.made(part, at) for part in found.parts], at + found.end

    def made(self, part: Any, base: int) -> Any:
        """The node of a form whose token indexes count from ``base``; other parts unchanged."""
        if type(part) is not Form:
            return part
        parts = [self.made(inner, base) for inner in part.parts]
        return part.build(self, base + part.start, base + part.end, parts)

    def _explained(self, fault: ParseBaseException, base: int) -> Fault:
        at = base + fault.loc
        bad = self.kinds.find(BAD_NUMBER, base, at)
        if bad >= 0:
            return self.bad_number(bad)
        message = fault.msg[:1].lower() + fault.msg[1:]
        if not isinstance(fault, Stop):
            return self.expected(at, message)
        if fault.opened is not None:
            line, column = self.source.position(self.tokens.offset(base + fault.opened))
            message = f"{message} of {line}:{column}"
        if fault.code == "syntax" and fault.hint is None:
            return self.expected(at, message)
        return Fault(at, message, code=fault.code, hint=fault.hint)

    # --- faults ---

    def expected(self, at: int, message: str) -> Fault:
        """A fault with this message, and a hint if the token suggests one."""
        hint, start, end = advice(self.tokens, at, message)
        span = self.span(start, end) if (start, end) != (at, at + 1) else None
        return Fault(at, message, span=span, hint=hint)

    def bad_number(self, at: int) -> Fault:
        """The fault of a malformed number."""
        found = self.text(at)
        message = f"'{found[:40]}' is not a number"
        hint: remedies.Hint = "numbers look like 42, 4.25 or 1e-3"
        if measured := _MEASURED.fullmatch(found):
            hint = remedies.write(measured[1], ": numbers have no unit")
        return Fault(at, message, code="bad-number", hint=hint)

    def report(
        self,
        code: str,
        message: str,
        at: int,
        hint: remedies.Hint | None = None,
        notes: tuple[Note, ...] = (),
        span: source.Span | None = None,
    ) -> None:
        """Add an error; without ``span`` it is at the token ``at``."""
        if at >= len(self.kinds):
            # The file ends too early: point right behind its last character.
            span = source.Span(self.source, self.tokens.end, self.tokens.end)
            message += ", but the file ends here"
        span = span or self.span(at, at + 1)
        self.diagnostics.append(Diagnostic(Severity.ERROR, code, message, span, hint, notes))

    def report_fault(self, start: int, resume: int, fault: Fault) -> None:
        """Add the fault in the declaration that begins at ``start``.

        Nothing is added if it follows from a lexical fault in ``start..resume``, or, at the end of
        the file, from an unterminated comment.
        """
        tokens, at = self.tokens, fault.at
        end = max(tokens.offset(resume), tokens.offset(at) + 1)
        if tokens.has_fault(tokens.offset(start), end):
            return
        if at >= len(self.kinds):
            if tokens.open_end or self.reported_at >= len(self.kinds):
                return
            self.reported_at = len(self.kinds)
        is_advised = fault.span is not None and fault.span.end <= tokens.offset(at)
        if not is_advised and at and fault.message.startswith(_INSIDE) and self._ends_line(at - 1):
            # An expression breaks off at the end of its line: the error is there, not below it.
            span = self.span(at - 1, at)
            self.report("syntax", fault.message, at - 1, span=span)
        else:
            self.report(fault.code, fault.message, at, fault.hint, span=fault.span)

    def _ends_line(self, index: int) -> bool:
        text = self.source.text[self.tokens.ends[index] : self.tokens.offset(index + 1)]
        return "\n" in text

    def skipped(self, start: int, end: int) -> None:
        """Add the words of a skipped declaration to ``broken``.

        Not those of a statement or transition, which declares nothing: unknown names elsewhere
        are then still reported.
        """
        words = [
            self.text(index).lstrip("^")
            for index in range(start, min(end, len(self.kinds)))
            if is_word(self.kinds[index])
        ]
        if words and words[0] in _STATEMENTS and _DECLARING.isdisjoint(words):
            return
        self.broken.update(words)

    @property
    def exhausted(self) -> bool:
        """Whether there are so many errors that parsing stops."""
        return len(self.diagnostics) > limits.LEXICAL_ERRORS


Build: TypeAlias = Callable[[ParseState, int, int, list[Any]], Any]
"""Builds a node from the reading, a half-open range of tokens, and the values of its parts."""
