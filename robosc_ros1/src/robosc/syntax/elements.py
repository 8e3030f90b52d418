"""Building blocks of the grammar: elements of pyparsing that match kinds of tokens.

``expected`` is the text behind "expected " in the message where an element does not match.
``a - b`` in a rule is pyparsing's error stop: once ``a`` has matched, ``b`` must.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from functools import cached_property, partial
from typing import Any, cast

from pyparsing import (
    Empty,
    MatchFirst,
    Optional,
    ParseBaseException,
    ParseElementEnhance,
    ParserElement,
    ParseResults,
    Regex,
    ZeroOrMore,
)

from robosc.language.tokens import pattern
from robosc.syntax import parse_state, pyparsing_names


class Unfinished(str):
    """The kinds of a declaration that is being typed: what could follow them notes itself."""

    def __new__(cls, kinds: str) -> Unfinished:
        made = super().__new__(cls, kinds)
        made.expected = []
        return made

    expected: list[str]

    def expandtabs(self, tabsize: Any = 8) -> Unfinished:
        return self  # pyparsing calls it, and would go on with a plain string


def note(kinds: str, at: int, expected: str) -> None:
    """Note what is expected at a place if an unfinished declaration ends there."""
    if at == len(kinds) and isinstance(kinds, Unfinished):
        kinds.expected.append(expected)


def expectations(rule: ParserElement, kinds: str) -> tuple[tuple[str, ...], list[Any] | None]:
    """What may follow the kinds of an unfinished declaration; its parts if it could end there."""
    unfinished = Unfinished(kinds)
    try:
        *parts, end = pyparsing_names.parse_string(rule, unfinished)
    except ParseBaseException:
        parts, end = [], -1
    whole = [part for part in parts if type(part) is not str] if end == len(kinds) else None
    return tuple(dict.fromkeys(unfinished.expected)), whole


class _Terminal(Regex):
    """Tokens that match a pattern."""

    def parseImpl(self, instring: str, loc: int, do_actions: bool = True) -> Any:
        if loc == len(instring):
            note(instring, loc, self.name)
        return super().parseImpl(instring, loc, do_actions)


def terminal(kinds: str, expected: str, build: parse_state.Build | None = None) -> ParserElement:
    """Tokens that match a pattern (see :func:`~robosc.language.tokens.pattern`).

    Without ``build`` they leave no part behind, as keywords and punctuation do.
    """
    element = pyparsing_names.set_name(
        pyparsing_names.leave_whitespace(_Terminal(pattern(kinds))), expected
    )
    if build is None:
        return element

    def leave(kinds: str, loc: int, found: ParseResults) -> parse_state.Form:
        return parse_state.Form(build, loc, loc + len(found[0]), [])

    return pyparsing_names.set_parse_action(element, leave)


def keyword(word: str, expected: str = "") -> ParserElement:
    """A keyword, or a pattern; leaves nothing."""
    return terminal(word, expected or f"'{word}'")


def symbol(characters: str, expected: str = "") -> ParserElement:
    """A token of punctuation; leaves nothing."""
    return terminal(f"'{characters}'", expected or f"'{characters}'")


def label(word: str) -> ParserElement:
    """A keyword and a colon; leaves nothing."""
    return terminal(f"{word} ':'", f"'{word}:'")


def _word(reading: parse_state.ParseState, start: int, end: int, parts: list[Any]) -> str:
    return reading.text(start)


def choice(words: str, expected: str) -> ParserElement:
    """One of several keywords, given as a pattern; leaves the word."""
    return terminal(words, expected, _word)


def either(alternatives: Sequence[ParserElement], expected: str) -> ParserElement:
    """The first of the alternatives that matches."""
    return pyparsing_names.set_name(MatchFirst(alternatives), expected)


def maybe(part: ParserElement, default: Any = None) -> ParserElement:
    """The part, or ``default`` where it does not match."""
    return Optional(part, default=default)


def listed(part: ParserElement) -> ParserElement:
    """One or more of the part, separated by commas."""
    return part + ZeroOrMore(symbol(",") - part)


class _Later(ParseElementEnhance):
    def __init__(self, make: Callable[[], ParserElement]) -> None:
        super().__init__(cast(Any, None))
        self._make = make

    @cached_property
    def _made(self) -> ParserElement:
        return self._make().streamline()

    def parseImpl(self, instring: str, loc: int, do_actions: bool = True) -> Any:
        return self._made._parse(instring, loc, do_actions, False)


def later(make: Callable[[], ParserElement]) -> ParserElement:
    """A rule that is made where a text first comes to it: it may contain itself, and be large."""
    return pyparsing_names.set_name(
        _Later(make), "…"
    )  # version 2.4 of pyparsing shows it without being asked


def nothing() -> ParserElement:
    """The empty sequence of tokens."""
    return pyparsing_names.leave_whitespace(Empty())


def ended(rule: ParserElement) -> ParserElement:
    """The rule; leaves the index of the token behind it as its last part."""
    end = pyparsing_names.set_parse_action(nothing(), lambda kinds, loc, found: [loc])
    return rule + end


def built(rule: ParserElement, build: parse_state.Build) -> ParserElement:
    """A rule whose parts become one node, made by ``build``."""

    def leave(kinds: str, loc: int, found: ParseResults) -> parse_state.Form:
        *parts, end = found
        return parse_state.Form(build, loc, end, [part for part in parts if type(part) is not str])

    return pyparsing_names.set_parse_action(ended(rule), leave)


def nested(make: Callable[[ParserElement], ParserElement], limit: int, what: str) -> ParserElement:
    """A rule that contains itself, to a limit, so that no text can exhaust the stack."""
    rule = refused(nothing(), limit, what)
    for _ in range(limit):
        rule = later(partial(make, rule))
    return rule


def refused(element: ParserElement, limit: int, what: str) -> ParserElement:
    """An element that matches only beyond the limit of nesting, and then stops the parse."""

    def refuse(kinds: str, loc: int, found: ParseResults) -> None:
        at = loc + sum(map(len, found))
        raise parse_state.Stop(kinds, at, f"{what} nested more than {limit} deep", code="too-deep")

    return pyparsing_names.set_parse_action(element, refuse)
