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
from robosc.syntax.nodes import ArrayTypeNode, BasicTypeNode, NamedTypeNode, RosTypeNode, StringNode
from robosc.syntax.reading import Reading
from robosc.syntax.values import make_access, make_integer, make_name, make_string

__all__ = [
    "MAX_NESTING", "communication", "communications", "name", "ros_type", "string", "type_",
]  # fmt: skip

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
    kind <<= either([too_deep, basic, integer, array, ros_type("a type"), named], expected)
    return kind


def ros_type(expected: str) -> ParserElement:
    """``package/Type``, or with ``msg``, ``srv`` or ``action`` between the two."""
    return terminal(f"NAME '/' WORD (?: '/' WORD )? {_NO_COLON}", expected, _build_ros_type)


def _build_ros_type(reading: Reading, start: int, end: int, parts: list[Any]) -> RosTypeNode:
    package, *middle, type_ = (make_name(reading, at, at + 1, []) for at in range(start, end, 2))
    written = middle[0] if middle else None
    return RosTypeNode(package, type_, written, span=reading.span(start, end))


def _build_basic(reading: Reading, start: int, end: int, parts: list[Any]) -> BasicTypeNode:
    return BasicTypeNode(cast(Any, reading.text(start)), span=reading.span(start, end))


def _build_named(reading: Reading, start: int, end: int, parts: list[Any]) -> NamedTypeNode:
    return NamedTypeNode(make_name(reading, start, end, []), span=reading.span(start, end))


def _build_integer(reading: Reading, start: int, end: int, parts: list[Any]) -> BasicTypeNode:
    return BasicTypeNode("integer", parts[0], span=reading.span(start, end))


def _build_array(reading: Reading, start: int, end: int, parts: list[Any]) -> ArrayTypeNode:
    return ArrayTypeNode(parts[0], span=reading.span(start, end))
