"""Tokens, names and types: the small parts that the declarations are made of.

Each ``expected`` says in the user's words what is missing where the part is not found.
"""

from __future__ import annotations

from typing import Any, cast

from pyparsing import Forward, MatchFirst, Opt, ParserElement, ZeroOrMore

from robosc.syntax.elements import Built, ModelText, Nested, Terminal
from robosc.syntax.expressions import make_access, make_integer, make_name, unquote
from robosc.syntax.keywords import NAME, QUALIFIED
from robosc.syntax.nodes import ArrayTypeNode, BasicTypeNode, NamedTypeNode, StringNode

__all__ = [
    "MAX_NESTING", "choice", "communication", "keyword", "label", "listed", "maybe", "name",
    "nothing", "string", "symbol", "type_",
]  # fmt: skip

MAX_NESTING = 20
"""How deep arrays of arrays, and provided objects in objects, may be nested."""

_STRING = r"\"[^\"\\\n]*(?:\\.[^\"\\\n]*)*\"|'[^'\\\n]*(?:\\.[^'\\\n]*)*'"
# What has a colon behind it is the name of the next property: the type before it is missing.
_NO_COLON = r"(?!\w|\s*:(?!=))"


def keyword(word: str, expected: str = "") -> ParserElement:
    return Terminal(rf"{word}(?!\w)", expected or f"'{word}'")


def symbol(characters: str, expected: str = "") -> ParserElement:
    pattern = "".join(f"\\{c}" for c in characters)
    return Terminal(pattern, expected or f"'{characters}'")


def label(word: str, expected: str = "") -> ParserElement:
    """A keyword with its colon."""
    return Terminal(rf"{word}\s*:(?!=)", expected or f"'{word}:'")


def choice(words: str, expected: str) -> ParserElement:
    """One of several keywords; leaves the word."""
    return Terminal(rf"(?:{words})(?!\w)", expected, lambda text, start, end, found: found)


def nothing() -> ParserElement:
    """Takes no text and leaves None, where an optional part is absent."""
    return Terminal(r"", "", lambda text, start, end, found: None)


def maybe(part: ParserElement) -> ParserElement:
    """The part, or None in its place."""
    return Opt(part, default=None)


def listed(part: ParserElement) -> ParserElement:
    """One or more, with commas between them."""
    return part + ZeroOrMore(symbol(",") - part)


def name(expected: str) -> ParserElement:
    return Terminal(NAME, expected, make_name, is_name=True)


def communication(expected: str) -> ParserElement:
    return Terminal(QUALIFIED, expected, make_access, is_name=True)


def string(expected: str) -> ParserElement:
    def build(text: ModelText, start: int, end: int, found: str) -> StringNode:
        return StringNode(unquote(text, start, found), span=text.span(start, end))

    return Terminal(_STRING, expected, build)


def type_(expected: str) -> ParserElement:
    kind = Forward()
    bound = Terminal(r"-?\s*\d+(?!\w)", "a whole number", make_integer)
    bounds = symbol("(") - bound - symbol("..") - bound - symbol(")")
    integer = Built(keyword(f"integer{_NO_COLON}") + Opt(bounds), _build_integer)
    basic = Terminal(rf"(?:string|boolean|double|none){_NO_COLON}", "a type", _build_basic)
    array = Built(
        keyword(f"array{_NO_COLON}")
        - symbol("(", "'(' after 'array'")
        - kind
        - symbol(")", "')' to close 'array('"),
        lambda text, start, end, p: ArrayTypeNode(p[0], span=text.span(start, end)),
    )
    named = Terminal(rf"{NAME}{_NO_COLON}", "a type", _build_named, is_name=True)
    any_type = MatchFirst([basic, integer, array, named]).set_name(expected)
    kind <<= Nested(any_type, MAX_NESTING, "arrays are")
    return kind


def _build_basic(text: ModelText, start: int, end: int, found: str) -> BasicTypeNode:
    return BasicTypeNode(cast(Any, found), span=text.span(start, end))


def _build_named(text: ModelText, start: int, end: int, found: str) -> NamedTypeNode:
    return NamedTypeNode(make_name(text, start, end, found), span=text.span(start, end))


def _build_integer(text: ModelText, start: int, end: int, parts: list[Any]) -> BasicTypeNode:
    bounds = (parts[0], parts[1]) if parts else None
    # Without bounds, ``end`` is where they were looked for: behind white space.
    end = end if parts else start + len("integer")
    return BasicTypeNode("integer", bounds, span=text.span(start, end))
