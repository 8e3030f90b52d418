"""The grammar of names, communications, ranges, durations, strings and types.

``expected`` is the text behind "expected " in the message where the part does not match.
"""

from __future__ import annotations

from typing import Any, cast

from pyparsing import ParserElement, ParseResults

from robosc import limits
from robosc.language.keywords import UNITS
from robosc.syntax import expressions, leaves, nodes, operands, pyparsing_names
from robosc.syntax.elements import (
    built,
    either,
    keyword,
    later,
    listed,
    maybe,
    refused,
    symbol,
    terminal,
)
from robosc.syntax.parse_state import ParseState, Stop

# A name before a colon is that of the next property: the type before it is missing.
_NO_COLON = "(?! ':' )"


def name(expected: str) -> ParserElement:
    """An identifier; leaves a Name."""
    return terminal("NAME", expected, leaves.make_name)


def state(expected: str) -> ParserElement:
    """A state: ``idle``, or by its path ``docking.near``; leaves a Name or an Access."""
    return terminal("QUALIFIED", expected, _build_state)


def _build_state(
    reading: ParseState, start: int, end: int, parts: list[Any]
) -> nodes.Name | nodes.Access:
    path: nodes.Access = leaves.make_access(reading, start, end, parts)
    return path if path.path else path.root


def communication(expected: str) -> ParserElement:
    """A communication: ``go``, ``Station.go`` or ``Station[i].go``; leaves an Access."""
    plain = terminal("QUALIFIED (?! '[' )", expected, leaves.make_access)
    indexed = built(
        terminal("NAME (?= '[' )", expected, leaves.make_name)
        - symbol("[")
        - expressions.Expression("an index in '[…]'")
        - symbol("]", "']' after the index")
        - maybe(terminal("'.' WORD", "'.' and the name of a communication", _build_member)),
        _build_indexed,
    )
    return either([plain, indexed], expected)


def _build_member(reading: ParseState, start: int, end: int, parts: list[Any]) -> nodes.Name:
    return leaves.make_name(reading, start + 1, end, [])


def _build_indexed(reading: ParseState, start: int, end: int, parts: list[Any]) -> nodes.Access:
    root, index, member = parts
    path = () if member is None else (member,)
    return nodes.Access(root, path, index, span=reading.span(start, end))


def as_communication(node: nodes.ExprNode) -> nodes.Access | None:
    """The access to the communication that an expression names; None if it is no such name."""
    match node:
        case nodes.Access(path=(int() as index, nodes.Name() as member)):
            number = nodes.LiteralNode(index, span=node.span)
            return nodes.Access(node.root, (member,), number, span=node.span)
        case nodes.Access(path=(int() as index,)):
            return nodes.Access(
                node.root, (), nodes.LiteralNode(index, span=node.span), span=node.span
            )
        case nodes.ElementNode(array=nodes.Access(root=root, path=()), index=index_):
            return nodes.Access(root, (), index_, span=node.span)
        case nodes.Access() if not any(isinstance(part, int) for part in node.path):
            return node
        case nodes.MemberNode(
            object=nodes.ElementNode(array=nodes.Access(root=root, path=()), index=index_),
            path=(nodes.Name() as member,),
        ):
            return nodes.Access(root, (member,), index_, span=node.span)
    return None


def braced_communications() -> ParserElement:
    """Several communications in braces, and what is left out; leaves a tuple."""
    return built(_braced() - maybe_except(), make_group)


def communications(expected: str) -> ParserElement:
    """One communication, or several in braces, and what is left out; leaves a tuple."""
    return built(named_communications(expected) - maybe_except(), make_group)


def maybe_except() -> ParserElement:
    """``except a``, which may itself end with ``except b``; leaves an ExceptNode or None."""
    return maybe(built(keyword("except") - later(_excepted), _build_except))


def _excepted() -> ParserElement:
    return named_communications("the name of a communication after 'except'") - maybe_except()


def named_communications(expected: str) -> ParserElement:
    """One communication, or several in braces; leaves a tuple."""
    one = built(communication("the name of a communication"), leaves.make_tuple)
    return either([_braced(), one], expected)


def _braced() -> ParserElement:
    one = communication("the name of a communication")
    return built(symbol("{") - listed(one) - symbol("}", "',' or '}'"), leaves.make_tuple)


def make_group(reading: ParseState, start: int, end: int, parts: list[Any]) -> nodes.Group:
    """The group of a tuple and what is left out of it, if there is such a part."""
    items, excepted = parts
    return items if excepted is None else (*items, excepted)


def _build_except(reading: ParseState, start: int, end: int, parts: list[Any]) -> nodes.ExceptNode:
    group = make_group(reading, start, end, parts)
    return nodes.ExceptNode(group, span=reading.span(start, end))


def range_() -> ParserElement:
    """``1..6``; leaves a RangeNode."""
    bound = terminal("'-'? INTEGER", "a whole number", leaves.make_integer)
    return built(
        bound - symbol("..", "'..' and the last index") - bound, leaves.make_node(nodes.RangeNode)
    )


def duration(expected: str) -> ParserElement:
    """``0.5 s``, or the name of a constant or parameter."""
    units = " | ".join(UNITS)
    return terminal(f"NUMBER (?: {units} ) | QUALIFIED", expected, operands.make_leaf)


def rate(expected: str) -> ParserElement:
    """``20 Hz``, which leaves a RateNode, or the word ``once``, which leaves a name."""
    hertz = terminal("NUMBER Hz", expected, _build_rate)
    return either([hertz, terminal("once", expected, leaves.make_name)], expected)


def _build_rate(reading: ParseState, start: int, end: int, parts: list[Any]) -> nodes.RateNode:
    return nodes.RateNode(leaves.make_number(reading, start), span=reading.span(start, end))


def replace(expected: str) -> ParserElement:
    """The word ``replace``; leaves it as a name."""
    return terminal("replace", expected, leaves.make_name)


def none(expected: str) -> ParserElement:
    """The word ``none``; leaves it as a name."""
    return terminal("none", expected, leaves.make_name)


def string(expected: str) -> ParserElement:
    """A string; leaves a StringNode."""
    return terminal("STRING", expected, build_string)


def build_string(reading: ParseState, start: int, end: int, parts: list[Any]) -> nodes.StringNode:
    """The node of a string."""
    return nodes.StringNode(leaves.make_string(reading, start), span=reading.span(start, end))


def type_(expected: str) -> ParserElement:
    """A type; leaves a node of one."""
    bound = terminal("'-'? INTEGER", "a whole number", leaves.make_integer)
    bounds = symbol("(") - bound - symbol("..") - bound - symbol(")")
    integer = built(
        keyword(f"integer {_NO_COLON}", "a type") + maybe(built(bounds, leaves.make_tuple)),
        leaves.make_node(nodes.BasicTypeNode, "integer"),
    )
    unbounded = terminal("(?: string | boolean | double | none ) '('", "a type")
    pyparsing_names.set_parse_action(unbounded, _refuse_range)
    basic = terminal(f"(?: string | boolean | double | none ) {_NO_COLON}", "a type", _build_basic)
    array = built(
        keyword(f"array {_NO_COLON}", "a type")
        - symbol("(", "'(' after 'array'")
        - later(lambda: kind)
        - symbol(")", "')' to close 'array('"),
        leaves.make_node(nodes.ArrayTypeNode),
    )
    named = terminal("NAME (?: '.' WORD )? (?! '.' | ':' )", "a type", _build_named)
    deep = terminal(f"(?: array '(' ){{{limits.NESTED_DATA}}}", "a type")
    too_deep = refused(deep, limits.NESTED_DATA, "arrays are")
    kind = either([too_deep, ros_type("a type"), unbounded, basic, integer, array, named], expected)
    return kind


def ranged_double() -> ParserElement:
    """``double(0.1..2.0)``, the type of a parameter; leaves a node of a type."""
    bound = terminal("'-'? NUMBER", "a number", _build_bound)
    bounds = symbol("(") - bound - symbol("..") - bound - symbol(")")
    opening = terminal("double (?= '(' )", "a type")
    return built(
        opening - built(bounds, leaves.make_tuple), leaves.make_node(nodes.BasicTypeNode, "double")
    )


def _build_bound(reading: ParseState, start: int, end: int, parts: list[Any]) -> float:
    number = float(leaves.make_number(reading, end - 1))
    return number if end == start + 1 else -number


def _refuse_range(kinds: str, loc: int, found: ParseResults) -> None:
    hint = "write the type alone, and compare the value where it decides"
    message = "only 'integer', and the 'double' of a parameter, have a range"
    raise Stop(kinds, loc + 1, message, hint=hint)


def ros_type(expected: str) -> ParserElement:
    """``package/Type``, or with ``msg``, ``srv`` or ``action`` between the two."""
    return terminal(f"WORD '/' WORD (?: '/' WORD )? {_NO_COLON}", expected, _build_ros_type)


def _build_ros_type(
    reading: ParseState, start: int, end: int, parts: list[Any]
) -> nodes.RosTypeNode:
    package, *middle, type_ = (
        leaves.make_name(reading, at, at + 1, []) for at in range(start, end, 2)
    )
    written = middle[0] if middle else None
    return nodes.RosTypeNode(package, type_, written, span=reading.span(start, end))


def interface(expected: str) -> ParserElement:
    """An interface, perhaps of a library: ``scan``, ``Library.scan``."""
    return terminal("NAME (?: '.' WORD )?", expected, _build_named)


def _build_basic(
    reading: ParseState, start: int, end: int, parts: list[Any]
) -> nodes.BasicTypeNode:
    return nodes.BasicTypeNode(cast(Any, reading.text(start)), span=reading.span(start, end))


def _build_named(
    reading: ParseState, start: int, end: int, parts: list[Any]
) -> nodes.NamedTypeNode:
    *library, name = (leaves.make_name(reading, at, at + 1, []) for at in range(start, end, 2))
    return nodes.NamedTypeNode(name, library[0] if library else None, span=reading.span(start, end))
