"""Names, strings and types: the small parts that the declarations are made of.

Each ``expected`` says in the user's words what is missing where the part is not found.
"""

from __future__ import annotations

from typing import Any, cast

from pyparsing import Forward, ParserElement

from robosc.syntax.elements import (
    built,
    either,
    keyword,
    listed,
    maybe,
    refused,
    symbol,
    terminal,
)
from robosc.syntax.nodes import ArrayTypeNode, BasicTypeNode, NamedTypeNode, StringNode
from robosc.syntax.reading import Reading
from robosc.syntax.values import make_access, make_integer, make_name, make_string

__all__ = ["MAX_NESTING", "communication", "communications", "name", "string", "type_"]

MAX_NESTING = 20
"""How deep arrays of arrays, and provided objects in objects, may be nested."""

# What has a colon behind it is the name of the next property: the type before it is missing.
_NO_COLON = "(?! ':' )"


def name(expected: str) -> ParserElement:
    return terminal("NAME", expected, make_name)


def communication(expected: str) -> ParserElement:
    return terminal("QUALIFIED", expected, make_access)


def communications() -> ParserElement:
    """Communications in braces; leaves them as one tuple."""
    one = communication("the name of a communication")
    return built(symbol("{") - listed(one) - symbol("}", "',' or '}'"), _tuple)


def _tuple(reading: Reading, start: int, end: int, parts: list[Any]) -> tuple[Any, ...]:
    return tuple(parts)


def string(expected: str) -> ParserElement:
    return terminal("STRING", expected, _build_string)


def _build_string(reading: Reading, start: int, end: int, parts: list[Any]) -> StringNode:
    return StringNode(make_string(reading, start), span=reading.span(start, end))


def type_(expected: str) -> ParserElement:
    kind = Forward()
    bound = terminal("'-'? INTEGER", "a whole number", make_integer)
    bounds = symbol("(") - bound - symbol("..") - bound - symbol(")")
    integer = built(keyword(f"integer {_NO_COLON}") + maybe(built(bounds, _tuple)), _build_integer)
    basic = terminal(f"(?: string | boolean | double | none ) {_NO_COLON}", "a type", _build_basic)
    array = built(
        keyword(f"array {_NO_COLON}")
        - symbol("(", "'(' after 'array'")
        - kind
        - symbol(")", "')' to close 'array('"),
        _build_array,
    )
    named = terminal(f"NAME {_NO_COLON}", "a type", _build_named)
    deep = terminal(f"(?: array '(' ){{{MAX_NESTING}}}", "a type")
    too_deep = refused(deep, MAX_NESTING, "arrays are")
    kind <<= either([too_deep, basic, integer, array, named], expected)
    return kind


def _build_basic(reading: Reading, start: int, end: int, parts: list[Any]) -> BasicTypeNode:
    return BasicTypeNode(cast(Any, reading.text(start)), span=reading.span(start, end))


def _build_named(reading: Reading, start: int, end: int, parts: list[Any]) -> NamedTypeNode:
    return NamedTypeNode(make_name(reading, start, end, []), span=reading.span(start, end))


def _build_integer(reading: Reading, start: int, end: int, parts: list[Any]) -> BasicTypeNode:
    return BasicTypeNode("integer", parts[0], span=reading.span(start, end))


def _build_array(reading: Reading, start: int, end: int, parts: list[Any]) -> ArrayTypeNode:
    return ArrayTypeNode(parts[0], span=reading.span(start, end))
