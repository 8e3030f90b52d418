"""The grammar of expressions: one element of pyparsing that parses them without recursion.

pyparsing's ``infix_notation`` tries every level of precedence for every operand and recurses for
each parenthesis. This element scans operands, operators and brackets in one loop instead, and
:mod:`robosc.syntax.operands` builds the tree with two stacks, so the cost is linear and no text can
exhaust the interpreter's stack.
"""

from __future__ import annotations

from typing import Any

from pyparsing import Empty, ParseException, ParseSyntaxException

from robosc import limits, remedies
from robosc.language import keywords, operators, tokens
from robosc.syntax import elements, operands, pyparsing_names
from robosc.syntax.parse_state import Form, Stop

ACCESS = "NAME (?: '.' WORD | '[' INTEGER ']' )*"

# A name with a colon behind it is a property: the brace before it is missing.
_OPERAND = tokens.pattern(
    f"(?! true | false | and | or ) {ACCESS} (?! ':' ) | NUMBER (?: {' | '.join(keywords.UNITS)} )"
    " | NUMBER | STRING | true | false"
)
_CALLED = tokens.pattern("(?! true | false | and | or ) QUALIFIED '('")
_MEMBER = tokens.pattern("'.' WORD '('")
_PARTS = tokens.pattern("(?: '.' WORD | '[' INTEGER ']' )+")
_IN = tokens.pattern("in '{'")
_ELSE_WITH = tokens.pattern("else with")  # of a provide statement
_FOR = tokens.pattern("for NAME (?: ',' NAME )? in")
_PREFIX = {tokens.kind_of(symbol): symbol for symbol in operators.UNARY}
_INFIX = {kind: symbol for symbol in operators.BINARY for kind in tokens.kinds_of(symbol)}
_FOREIGN = {tokens.kind_of(symbol): symbol for symbol in tokens.FOREIGN}
_IF, _FOR_WORD = frozenset(tokens.kinds_of("if")), frozenset(tokens.kinds_of("for"))

_CLOSING = {
    "group": ")", "call": ")", "called": ")", "arguments": ")", "over": ")", "filter": ")",
    "index": "]", "slice": "]", "array": "]", "elements": "]", "made": "]", "chosen": "]",
    "set": "}",
}  # fmt: skip
"""The closing character of each kind of bracket.

``called`` is a call of what stands before it, a function of an indexed component. A call with a
comma becomes ``arguments``, one with ``for`` becomes ``over`` (an aggregate), and ``filter`` behind
the aggregate's ``if``. An array becomes ``elements``, ``made`` and ``chosen``.
"""
_WITH_COMMA = {"call": "arguments", "called": "arguments", "array": "elements"}
_WITH_FOR = {"call": "over", "array": "made"}
_WITH_IF = {"over": "filter", "made": "chosen"}
_OPENING = {")": "(", "]": "[", "}": "{"}
_LISTS = ("call", "called", "arguments", "array", "elements", "set")


class Expression(Empty):
    """An expression; ``expected`` is the text behind "expected " where none begins."""

    def __init__(self, expected: str) -> None:
        super().__init__()  # type: ignore[no-untyped-call]
        pyparsing_names.set_name(pyparsing_names.leave_whitespace(self), expected)
        self._expected = expected

    def parseImpl(self, instring: str, loc: int, do_actions: bool = True) -> Any:
        scanner = _Scanner(instring)
        expected = self._expected
        at = loc
        while expected:
            elements.note(instring, at, expected)
            found = scanner.before_operand(at)
            if found is None:
                # Once a part of the expression has matched, no alternative rule can.
                failure = ParseSyntaxException if scanner.steps else ParseException
                raise failure(instring, at, f"expected {expected}", self)
            at, expected = found
            if not expected:
                at, expected = scanner.after_operand(at)
        return at, [Form(operands.build_expression, loc, at, [loc, scanner.steps])]


class _Scanner:
    """Collects the steps of one expression.

    ``brackets`` are those that are open: the kind of each and the token where it stands.
    """

    def __init__(self, kinds: str) -> None:
        self.kinds = kinds
        self.steps: list[operands.Step] = []
        self.brackets: list[tuple[str, int]] = []

    def before_operand(self, at: int) -> tuple[int, str] | None:
        """Scan an operand, a prefix or an opening bracket; None if there is none here.

        Returns the token behind it and, for messages, what must follow: "" behind an operand.
        """
        kinds = self.kinds
        kind = kinds[at : at + 1]
        if match := _OPERAND.match(kinds, at):
            if kinds[match.end() : match.end() + 1] == "(" and tokens.is_word(kind):
                called = _CALLED.match(kinds, at)
                if called is not None:
                    return self._open("call", at, called.end())
            self.steps.append(("operand", at, match.end(), ""))
            return match.end(), ""
        if kind in _PREFIX:
            self.steps.append(("prefix", at, at + 1, _PREFIX[kind]))
            return at + 1, f"a value after '{_PREFIX[kind]}'"
        if kind == "(":
            return self._open("group", at, at + 1)
        if kind == "[":
            return self._open("array", at, at + 1)
        return None

    def _open(self, what: str, at: int, end: int) -> tuple[int, str]:
        if len(self.brackets) >= limits.EXPRESSION_DEPTH:
            raise Stop(self.kinds, at, operands.nested_too_deep(), code="too-deep", hint="split it")
        self.brackets.append((what, end - 1))
        self.steps.append(("open", at, end, what))
        if what in ("call", "called", "array") and self.kinds[end : end + 1] == _CLOSING[what]:
            self._close(end)
            return end + 1, ""
        if what == "index":
            return end, "an index in '[…]'"
        if what == "set":
            return end, "a value in '{…}'"
        return end, f"an expression after '{self.kinds[end - 1]}'"

    def _close(self, at: int) -> None:
        self.brackets.pop()
        self.steps.append(("close", at, at + 1, ""))

    def after_operand(self, at: int) -> tuple[int, str]:
        """Scan what may follow an operand: an operator, a bracket, or the end of the expression.

        Returns the token behind it and, for messages, what must follow: "" at the end.
        """
        kinds = self.kinds
        while True:
            elements.note(kinds, at, "an operator")
            kind = kinds[at : at + 1]
            what = self.brackets[-1][0] if self.brackets else ""
            if kind in _INFIX and (what or not _ELSE_WITH.match(kinds, at)):
                self.steps.append(("operator", at, at + 1, _INFIX[kind]))
                return at + 1, f"a value after '{_INFIX[kind]}'"
            if kind and kind == _CLOSING.get(what):
                self._close(at)
                at += 1
                if what != "group" and (parts := _PARTS.match(kinds, at)):
                    self.steps.append(("parts", at, parts.end(), ""))
                    at = parts.end()
                continue
            if kind == "[" and self._has_elements():
                return self._open("index", at, at + 1)
            if kind == "(" and _MEMBER.match(kinds, at - 2) and self._has_elements():
                return self._open("called", at, at + 1)
            if match := _IN.match(kinds, at):
                return self._open("set", at, match.end())
            if what and (found := self._inside(what, at)):
                return found
            self._refuse(kind, at)
            return at, ""

    def _has_elements(self) -> bool:
        """Whether the operand before could be an array."""
        what, start, _, _ = self.steps[-1]
        return what != "operand" or tokens.is_word(self.kinds[start])

    def _inside(self, what: str, at: int) -> tuple[int, str] | None:
        """Scan what may follow an operand within brackets only; None if there is none of it."""
        kind = self.kinds[at : at + 1]
        if kind == "," and what in _LISTS:
            self.steps.append(("comma", at, at + 1, ""))
            self._becomes(_WITH_COMMA.get(what, what))
            return at + 1, "a value after ','"
        if kind == tokens.kind_of("..") and what == "index":
            self.steps.append(("comma", at, at + 1, ""))
            self._becomes("slice")
            return at + 1, "an index after '..'"
        if kind in _FOR_WORD and what in _WITH_FOR:
            match = _FOR.match(self.kinds, at)
            if match is None:
                raise Stop(self.kinds, at + 1, "expected a name and 'in' after 'for'")
            self.steps.append(("for", at, match.end(), ""))
            self._becomes(_WITH_FOR[what])
            return match.end(), "an array after 'in'"
        if kind in _IF and what in _WITH_IF:
            self.steps.append(("comma", at, at + 1, ""))
            self._becomes(_WITH_IF[what])
            return at + 1, "a condition after 'if'"
        return None

    def _becomes(self, what: str) -> None:
        """Say what kind of bracket the innermost open one has turned out to be."""
        self.brackets[-1] = (what, self.brackets[-1][1])

    def _refuse(self, kind: str, at: int) -> None:
        """Raise Stop if the expression cannot end at a token."""
        if kind in _FOREIGN:
            found = _FOREIGN[kind]
            hint = remedies.write(tokens.FOREIGN[found])
            raise Stop(self.kinds, at, f"'{found}' is not an operator", hint=hint)
        if kind == ".":
            raise Stop(self.kinds, at + 1, "expected a name after '.'")
        if self.brackets:
            what, opened = self.brackets[-1]
            closing = _CLOSING[what]
            message = f"expected an operator, or '{closing}' to close the '{_OPENING[closing]}'"
            raise Stop(self.kinds, at, message, opened=opened)
