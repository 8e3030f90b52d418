"""Builders of the leaves of the tree: names, accesses, numbers and strings."""

from __future__ import annotations

import re
from collections.abc import Callable
from typing import Any

from robosc.language import keywords, tokens
from robosc.remedies import write
from robosc.source import Span
from robosc.syntax.nodes import Access, Name
from robosc.syntax.parse_state import Build, Fault, ParseState
from robosc.syntax.recovery.advice import is_communication

MAX_INTEGER = 2**64 - 1
"""The largest whole number of any ROS type (uint64)."""


def make_name(reading: ParseState, start: int, end: int, parts: list[Any]) -> Name:
    """A name; a reserved word without its escape is reported, and used as the name."""
    found = reading.text(start)
    if found in keywords.RESERVED:
        reading.report(
            "reserved-name", f"'{found}' is a keyword everywhere", start, write(f"^{found}")
        )
    return Name(found.removeprefix("^"), span=reading.span(start, start + 1))


def make_access(reading: ParseState, start: int, end: int, parts: list[Any]) -> Access:
    """``a.b[0].c``; a reserved word such as ``value`` may be its root."""
    span = reading.span(start, end)
    root = reading.text(start).removeprefix("^")
    if end == start + 1:
        return Access(Name(root, span=span), (), span=span)
    if reading.text(start + 2) == "value" and is_communication(reading.tokens, root):
        hint = write(reading.span(start + 2, end).text, f", in a transition on {root}")
        raise Fault(start, "data have no name but 'value'", span=span, hint=hint)
    path = make_parts(reading, start + 1, end)
    return Access(Name(root, span=reading.span(start, start + 1)), path, span=span)


def make_parts(reading: ParseState, at: int, end: int) -> tuple[Name | int, ...]:
    """The path ``.b[0].c``: members and literal indexes.

    Raises:
        Fault: an index is too large.
    """
    path: list[Name | int] = []
    while at < end:
        if reading.kind(at) == ".":
            path.append(make_name(reading, at + 1, at + 2, []))
            at += 2
        else:
            path.append(make_integer(reading, at + 1, at + 2, []))
            at += 3
    return tuple(path)


def make_integer(reading: ParseState, start: int, end: int, parts: list[Any]) -> int:
    """The value of digits with an optional sign.

    Raises:
        Fault: it is beyond ``MAX_INTEGER``; Python's own conversion has a limit, too.
    """
    digits = reading.text(end - 1).lstrip("0") or "0"
    if len(digits) > 20 or int(digits) > MAX_INTEGER:
        message = f"this number is too large: whole numbers go up to {MAX_INTEGER}"
        raise Fault(start, message, span=reading.span(start, end), code="number-too-large")
    return int(digits) if end == start + 1 else -int(digits)


def make_number(reading: ParseState, at: int) -> int | float:
    """The value of a number.

    Raises:
        Fault: it is malformed or too large.
    """
    if reading.kind(at) == tokens.INTEGER:
        return make_integer(reading, at, at + 1, [])
    found = reading.text(at)
    if reading.kind(at) == tokens.BAD_NUMBER:
        raise reading.bad_number(at)
    number = float(found)
    if number == float("inf"):
        raise Fault(at, "this number is too large for a double", code="number-too-large")
    return number


def make_string(reading: ParseState, at: int) -> str:
    """The content of a string, escapes replaced; taken as it is if the string is unterminated.

    Raises:
        Fault: an escape is not one of the language.
    """
    body = reading.text(at)[1:-1]
    if "\\" not in body or reading.tokens.is_fault(at):
        return body

    def replace(match: re.Match[str]) -> str:
        escape = tokens.ESCAPES.get(match.group(1))
        if escape is None:
            place = reading.tokens.offset(at) + 1 + match.start()
            message = f"'{match.group()}' is not an escape"
            hint = r"there are \n \t \\ \" \'"
            span = Span(reading.source, place, place + 2)
            raise Fault(at, message, span=span, code="bad-escape", hint=hint)
        return escape

    return re.sub(r"\\(.)", replace, body)


def make_node(kind: Callable[..., Any], *first: Any, fixed: int | None = None) -> Build:
    """A builder of nodes of one kind from their parts in order.

    ``first`` are further arguments before them; the parts from index ``fixed`` on become one tuple.
    """

    def build(reading: ParseState, start: int, end: int, parts: list[Any]) -> Any:
        if fixed is not None:
            parts[fixed:] = [tuple(parts[fixed:])]
        return kind(*first, *parts, span=reading.span(start, end))

    return build


def make_tuple(reading: ParseState, start: int, end: int, parts: list[Any]) -> Any:
    """The parts as a tuple."""
    return tuple(parts)
