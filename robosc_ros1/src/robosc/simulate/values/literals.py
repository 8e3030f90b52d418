"""Values as a user writes them: literals, and literals by path for objects.

They are made of the tokens of the language; arrays are written as in JSON.
"""

from __future__ import annotations

import json
import re
from collections.abc import Mapping
from typing import Any, TypeAlias

from robosc import limits, source
from robosc.expr.types import Value
from robosc.language.tokens import (
    ESCAPES,
    INTEGER,
    NUMBER,
    STRING,
    Tokens,
    kind_of,
    pattern,
    tokenize,
)
from robosc.runtime.core.values import jsonable
from robosc.simulate.faults import InvalidLine

Path: TypeAlias = tuple[str | int, ...]
Raw: TypeAlias = Any
"""None, a literal, or a dict of literals by path, None for an array's element that is missing."""

_WORDS: Mapping[str, Raw] = {"true": True, "false": False, "missing": None}
_NAME = re.compile(pattern("WORD (?: '.' WORD )*"))
_LITERAL = re.compile(f"{STRING}|{kind_of('-')}?(?:[{INTEGER}{NUMBER}]|{_NAME.pattern})")
_PATH = re.compile(pattern("WORD (?: '.' WORD | '[' INTEGER ']' )*"))
_FIELD = re.compile(f"({STRING}|{_PATH.pattern})[{kind_of(':')}{kind_of('=')}]")
_LONGEST_INDEX = 6


def parse_raw(text: str) -> Raw:
    """``0.4``, ``free``, ``"text"``; ``x: 1, kind = free`` for an object. Raises InvalidLine."""
    tokens = tokenize(source.Source("value", text))
    if tokens.faults:
        raise _unread(text[tokens.faults[0] :])
    if not tokens:
        return None
    whole, at = _value_at(tokens, 0) or (None, 0)
    if at == len(tokens):
        return by_path(whole) if isinstance(whole, dict) else whole
    fields: dict[str, Raw] = {}
    if tokens.kinds[at : at + 2] == kind_of(",") + STRING:
        fields[""] = whole
        at += 1
    else:
        at = 0
    given, at = _fields_at(tokens, at)
    if at < len(tokens):
        raise _unread(text[tokens.offset(at) :])
    return {**fields, **by_path(given)}


def _fields_at(tokens: Tokens, at: int, depth: int = 0) -> tuple[dict[str, Raw], int]:
    """``x: 1, pose: { x: 2 }`` from a token on, and the token behind it."""
    fields: dict[str, Raw] = {}
    while field := _FIELD.match(tokens.kinds, at):
        found = _value_at(tokens, field.end(), depth)
        if found is None:
            break
        path = "".join(tokens.texts(at, field.end(1)))
        if path in fields:
            raise InvalidLine(f"'{path}' is given twice")
        fields[path], at = found
        at += tokens.kinds[at : at + 1] == kind_of(",")
    return fields, at


def by_path(fields: Mapping[str, Raw]) -> dict[str, Raw]:
    """The parts of objects in objects by their paths, as if each were written by its own."""
    found: dict[str, Raw] = {}
    for name, value in fields.items():
        parts = {name: value}
        if isinstance(value, dict):
            parts = {f"{name}.{path}": part for path, part in by_path(value).items()}
        for path, part in parts.items():
            if path in found:
                raise InvalidLine(f"'{path}' is given twice")
            found[path] = part
    return found


def _unread(text: str) -> InvalidLine:
    return InvalidLine(
        f"cannot read '{text}': a value is 0.4, true, a name, \"text\" or [0.4, NaN];"
        " that of an object x: 0.4, y: 2, or pose: { x: 0.4 }"
    )


def _end(what: re.Pattern[str], tokens: Tokens, at: int) -> int:
    found = what.match(tokens.kinds, at)
    return found.end() if found else at


def _value_at(tokens: Tokens, at: int, depth: int = 0) -> tuple[Raw, int] | None:
    """The value at a token and the token behind it; None too deep in others, as in the model."""
    if depth > limits.NESTED_DATA:
        return None
    if tokens.text(at) == "[":
        try:
            array, end = json.JSONDecoder().raw_decode(tokens.source.text, tokens.offset(at))
        except (ValueError, RecursionError):
            return _array_at(tokens, at + 1, depth + 1)
        return array, tokens.before(end)
    if tokens.text(at) == "{":
        fields, end = _fields_at(tokens, at + 1, depth + 1)
        return (fields, end + 1) if tokens.text(end) == "}" else None
    end = _end(_LITERAL, tokens, at)
    return None if end == at else (_literal(tokens, at, end), end)


def _array_at(tokens: Tokens, at: int, depth: int) -> tuple[Raw, int] | None:
    """Elements as in the model, behind the bracket: ``[{ x: 1 }, free]``."""
    elements: list[Raw] = []
    while tokens.text(at) != "]":
        found = _value_at(tokens, at, depth)
        if found is None:
            return None
        element, at = found
        elements.append(element)
        if tokens.text(at) == ",":
            at += 1
        elif tokens.text(at) != "]":
            return None
    return elements, at + 1


def _literal(tokens: Tokens, start: int, end: int) -> Raw:
    text = "".join(tokens.texts(start, end))
    kind = tokens.kinds[end - 1]
    if kind == STRING:
        return re.sub(r"\\(.)", _escape, text[1:-1])
    if kind == INTEGER and len(text) <= 20:
        return int(text)
    if kind in INTEGER + NUMBER:
        return float(text)
    return _WORDS[text] if text in _WORDS else text.replace("^", "")


def _escape(match: re.Match[str]) -> str:
    if match[1] not in ESCAPES:
        raise InvalidLine(f"'{match.group()}' is not an escape: there are \\n \\t \\\\ \\\" \\'")
    return ESCAPES[match[1]]


def path_in(text: str) -> Path | None:
    """The path that a text such as ``pose.x`` or ``ranges[0]`` is; None if it is none."""
    tokens = tokenize(source.Source("path", text))
    if tokens.faults or not _PATH.fullmatch(tokens.kinds):
        return None
    steps = [(kind, step) for kind, step in zip(tokens.kinds, tokens.texts(), strict=True)]
    if any(kind == INTEGER and len(step) > _LONGEST_INDEX for kind, step in steps):
        return None
    return tuple(
        int(step) if kind == INTEGER else step.removeprefix("^")
        for kind, step in steps
        if step not in ".[]"
    )


def literal_text(value: Value | None, quoted: bool = False) -> str:
    """A value as it can be typed again; names of enum values stay bare, unless ``quoted``."""
    match value:
        case None:
            return "missing"
        case bool():
            return "true" if value else "false"
        case str():
            if not quoted and _is_name(value):
                return value
            escaped = value.replace("\\", "\\\\").replace('"', '\\"')
            return '"' + escaped.replace("\n", "\\n").replace("\t", "\\t") + '"'
    text = jsonable(value)
    if isinstance(text, list | dict):
        return json.dumps(value, default=jsonable)  # NaN and infinities are no strings there
    return text if isinstance(text, str) else repr(text)


def _is_name(text: str) -> bool:
    """Whether a text that is typed without quotes is read as this text."""
    tokens = tokenize(source.Source("value", text))
    whole = not tokens.faults and "".join(tokens.texts()) == text
    return whole and text not in _WORDS and "^" not in text and bool(_NAME.fullmatch(tokens.kinds))
