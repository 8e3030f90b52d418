"""One reading of a model text: its tokens, the faults found so far, and how they are reported.

The grammar is a constant and holds no state; all of that is here.
"""

from __future__ import annotations

import re
from collections.abc import Callable
from dataclasses import dataclass
from difflib import get_close_matches
from functools import lru_cache
from typing import Any, TypeAlias

from pyparsing import ParseBaseException, ParserElement, ParseSyntaxException

from robosc.errors import Diagnostic, Note, Severity
from robosc.language.functions import FUNCTIONS
from robosc.language.keywords import UNITS
from robosc.language.tokens import BAD_NUMBER, MAX_FAULTS, Tokens, is_word
from robosc.source import Span

__all__ = ["Build", "Fault", "Form", "Reading", "Stop"]

_STATEMENTS = frozenset({"requirement", "provide", "on", "transition"})
_DECLARING = frozenset(
    {"component", "datatype", "interface", "message", "service", "action", "variable", "state"}
)
_INSIDE = ("expected a value after", "expected an operator")
_QUOTED = re.compile(r"'(\w+)")
_ADVICE = {
    "not": "write '!' for 'not'",
    "and": "write '^and' if this is a name",
    "or": "write '^or' if this is a name",
    "true": "write '^true' if this is a name",
    "false": "write '^false' if this is a name",
    ".": "a number begins with a digit, as in 0.5",
    "in": "the values stand in braces: x in { a, b }",
    "between": "write a <= x and x <= b",
}
_NAMING = "write 'condition NAME = …', or 'constant NAME: type = …'"
_DECLARED_ELSEWHERE = {
    **dict.fromkeys(("let", "define", "def", "macro"), _NAMING),
    "var": "a component's behaviour has variables: 'variable NAME: type'",
}
"""What other languages begin declarations with, each with what is meant."""

_WINDOW = 64
_LOOKAHEAD = 8
"""No rule of the grammar looks further ahead than so many tokens."""


class Fault(Exception):
    """What is wrong with the declaration that is being read.

    It begins at the token ``at``. ``span`` is its extent if that is not the token.
    """

    def __init__(
        self,
        at: int,
        message: str,
        *,
        span: Span | None = None,
        code: str = "syntax",
        hint: str | None = None,
    ) -> None:
        super().__init__(message)
        self.at = at
        self.message = message
        self.span = span
        self.code = code
        self.hint = hint


class Stop(ParseSyntaxException):
    """A fault found by the grammar that needs more than "expected …".

    ``opened`` is the token of the bracket that the message is about.
    """

    def __init__(
        self,
        kinds: str,
        at: int,
        message: str,
        *,
        code: str = "syntax",
        hint: str | None = None,
        opened: int | None = None,
    ) -> None:
        super().__init__(kinds, at, message)
        self.code = code
        self.hint = hint
        self.opened = opened


@dataclass(frozen=True, slots=True)
class Form:
    """What the grammar leaves of a rule: its extent in tokens, its parts, and what makes its node.

    The grammar sees kinds of tokens only. Once a declaration is read, :meth:`Reading.made` turns
    its forms into nodes.
    """

    build: Build
    start: int
    end: int
    parts: list[Any]


@dataclass(frozen=True, slots=True)
class _Applied:
    """What a rule of the grammar finds in a window of tokens, and where it ends or goes wrong."""

    parts: tuple[Any, ...]
    end: int
    fault: ParseBaseException | None = None


@lru_cache(maxsize=2**14)
def _applied(grammar: ParserElement, kinds: str) -> _Applied:
    """What a rule finds at the beginning of some tokens.

    Remembered, since only their kinds count: a text is read anew after each key in an editor, and
    twice when it is formatted, and most declarations in it look like others.
    """
    try:
        *parts, end = grammar.parse_string(kinds)
    except ParseBaseException as error:
        # The traceback would keep every frame of the parse alive.
        return _Applied((), error.loc, error.with_traceback(None))
    return _Applied(tuple(part for part in parts if type(part) is not str), end)


class Reading:
    """The tokens of one source, and what one parse finds in them.

    ``reported_at`` is a token whose fault is already reported: what goes wrong exactly there is its
    consequence. ``reopened`` means that a block was continued behind its closing brace, so that the
    braces no longer count. ``broken`` collects the words of everything that was skipped: names that
    later stages must not call unknown. ``lifted`` holds, by block, nodes of declarations that stood
    in a block inside it. ``depth`` counts the open blocks.
    """

    def __init__(self, tokens: Tokens) -> None:
        self.tokens = tokens
        self.kinds = tokens.kinds
        self.source = tokens.source
        self.diagnostics: list[Diagnostic] = list(tokens.diagnostics)
        self.broken: set[str] = set()
        self.lifted: dict[Any, list[Any]] = {}
        self.depth = 0
        self.reported_at = -1
        self.reopened = False

    def text(self, index: int) -> str:
        return self.tokens.text(index)

    def span(self, start: int, end: int) -> Span:
        return self.tokens.span(start, end)

    def kind(self, index: int) -> str:
        """The kind of a token; empty behind the last one."""
        return self.kinds[index : index + 1]

    # --- reading ---

    def parse(self, grammar: ParserElement, at: int) -> tuple[list[Any], int]:
        """Apply a rule to the tokens from ``at`` on: its parts as nodes, and where it ended.

        The rule is handed a window of the tokens, and a larger one if it has come near its end.
        Raises Fault.
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
        """The node of a form whose places count from the token ``base``."""
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
        return Fault(at, message, code=fault.code, hint=fault.hint)

    # --- faults ---

    def expected(self, at: int, message: str) -> Fault:
        """A fault that says what was expected, with a remedy where the token shows one."""
        return Fault(at, message, hint=self._hint(at, message))

    def bad_number(self, at: int) -> Fault:
        message = f"'{self.text(at)[:40]}' is not a number"
        return Fault(at, message, code="bad-number", hint="numbers look like 42, 4.25 or 1e-3")

    def report(
        self,
        code: str,
        message: str,
        at: int,
        hint: str | None = None,
        notes: tuple[Note, ...] = (),
        span: Span | None = None,
    ) -> None:
        """Add an error; without ``span`` it has the extent of the token ``at``."""
        if at >= len(self.kinds):
            # The file ends too early: point right behind its last character.
            span = Span(self.source, self.tokens.end, self.tokens.end)
            message += ", but the file ends here"
        span = span or self.span(at, at + 1)
        self.diagnostics.append(Diagnostic(Severity.ERROR, code, message, span, hint, notes))

    def report_fault(self, start: int, resume: int, fault: Fault) -> None:
        """Add what went wrong in the declaration that begins at ``start``.

        Nothing is added where a lexical fault in ``start..resume`` explains it, or, at the end of
        the file, a comment that was never closed.
        """
        tokens, at = self.tokens, fault.at
        end = max(tokens.offset(resume), tokens.offset(at) + 1)
        if tokens.has_fault(tokens.offset(start), end):
            return
        if at >= len(self.kinds):
            if tokens.open_end or self.reported_at >= len(self.kinds):
                return
            self.reported_at = len(self.kinds)
        if at and fault.message.startswith(_INSIDE) and self._ends_line(at - 1):
            # An expression breaks off at the end of its line: what comes next is not to blame.
            span = self.span(at - 1, at)
            self.report("syntax", fault.message, at - 1, span=span)
        else:
            self.report(fault.code, fault.message, at, fault.hint, span=fault.span)

    def _ends_line(self, index: int) -> bool:
        text = self.source.text[self.tokens.ends[index] : self.tokens.offset(index + 1)]
        return "\n" in text

    def _hint(self, at: int, message: str) -> str | None:
        """The remedy, where what was found shows what was meant."""
        found = self.text(at)
        if not found:
            return None
        if found == "=" and message.startswith("expected ':='"):
            return "write ':=' to assign"
        if found == "," and message.startswith("expected 'needs'"):
            return "several stand in braces: { …, … }"
        if message.startswith("expected a duration") and found[0].isdigit():
            return f"a duration has a unit: {', '.join(UNITS)}"
        if message.startswith("expected '=' after the name of the condition"):
            return "write 'condition NAME = …': a condition has no type"
        if message.startswith("expected ':' after the name of the constant"):
            return "write 'constant NAME: type = …'"
        if "'component'" in message and found in _DECLARED_ELSEWHERE:
            return _DECLARED_ELSEWHERE[found]
        if found == "timeout" and self._is_of_incoming_message(at):
            return "the controller sends it: only what it hears or asks for has a timeout"
        if found == "not" and self.text(at + 1) == "in":
            return "write !(x in { a, b })"
        if found in _ADVICE:
            return _ADVICE[found]
        if at and (function := self.text(at - 1)) in FUNCTIONS and found != "(":
            return f"write {function}(…)"
        if f"'{found}:'" in message:
            if self.kind(at + 1) != ":":
                return f"write '{found}:' with its colon"
            missing = "'with'" if message.startswith("expected 'with'") else "a ','"
            return f"{missing} is missing before it"
        cutoff = 0.6 if len(found) > 3 else 0.7
        words = _QUOTED.findall(message) if len(found) < 30 else []
        near = get_close_matches(found, words, 1, cutoff)
        return f"did you mean '{near[0]}'?" if near and near[0] != found else None

    def _is_of_incoming_message(self, at: int) -> bool:
        """Whether an attribute stands in the declaration of an incoming message."""
        while at and self.text(at) != "with":
            at -= 1
        return at > 2 and self.text(at - 3) == "incoming"

    def skipped(self, start: int, end: int) -> None:
        """Remember the words of a declaration that will not be in the tree.

        A statement or transition declares nothing, so that unknown names elsewhere stay unknown.
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
        """There are so many errors that reading on helps nobody."""
        return len(self.diagnostics) > MAX_FAULTS


Build: TypeAlias = Callable[[Reading, int, int, list[Any]], Any]
"""Makes a node from the reading, its extent in tokens, and the values of its parts."""
