"""Values as a user writes them: literals, and literals by path for objects."""

from __future__ import annotations

import json
import re
from collections.abc import Mapping
from typing import Any, TypeAlias

from robosc.model.types import (
    Value,
)
from robosc.runtime.values import jsonable
from robosc.simulate.faults import InvalidLine

__all__ = ["PATH", "Raw", "literal_text", "parse_raw"]

Raw: TypeAlias = Any
"""None, a literal, or a dict of literals by path, None for an array's element that is missing."""

_WORDS: Mapping[str, Raw] = {"true": True, "false": False, "missing": None}
_LITERAL = re.compile(
    r"""(?P<string>"(?:[^"\\]|\\.)*"|'(?:[^'\\]|\\.)*')
    |(?P<number>-?\d+(?:\.\d+)?(?:[eE][+-]?\d+)?)(?![\w.])
    |(?P<word>-?\^?[A-Za-z_]\w*(?:\.[A-Za-z_]\w*)*)""",
    re.VERBOSE | re.ASCII,
)
PATH = re.compile(r"[A-Za-z_]\w*(?:\.[A-Za-z_]\w*|\[\d{1,6}\])*", re.ASCII)
_TEST = re.compile(r'"(?:[^"\\]|\\.)*"')
_ESCAPES = {"n": "\n", "t": "\t"}


def parse_raw(text: str) -> Raw:
    """``0.4``, ``free``, ``"text"``; ``x: 1, kind = free`` for an object. Raises InvalidLine."""
    text = text.strip()
    if not text:
        return None
    match = _LITERAL.fullmatch(text)
    if match:
        return _literal(match)
    fields: dict[str, Raw] = {}
    at = 0
    if whole := re.match(rf"(?:{_LITERAL.pattern})\s*,\s*(?=\")", text, _LITERAL.flags):
        fields[""], at = parse_raw(whole.group().rstrip(", \t")), whole.end()
    while at < len(text):
        path = _TEST.match(text, at) or PATH.match(text, at)
        sign = re.compile(r"\s*[:=]\s*").match(text, path.end()) if path else None
        found = _value_at(text, sign.end()) if sign else None
        if path is None or sign is None or found is None:
            raise InvalidLine(
                f"cannot read '{text[at:]}': a value is 0.4, true, a name or \"text\";"
                " that of an object x: 0.4, y: 2"
            )
        if path.group() in fields:
            raise InvalidLine(f"'{path.group()}' is given twice")
        fields[path.group()], end = found
        gap = re.compile(r"\s*,\s*|\s+|$").match(text, end)
        if gap is None:
            raise InvalidLine(f"cannot read '{text[end:]}' behind '{text[sign.end() : end]}'")
        at = gap.end()
    return fields


def _value_at(text: str, at: int) -> tuple[Raw, int] | None:
    """The literal at a place and where it ends; an array is written as in JSON."""
    if text.startswith("[", at):
        try:
            return json.JSONDecoder().raw_decode(text, at)
        except ValueError:
            return None
    literal = _LITERAL.match(text, at)
    return None if literal is None else (_literal(literal), literal.end())


def _literal(match: re.Match[str]) -> Raw:
    text = match.group()
    if match.lastgroup == "string":
        return re.sub(r"\\(.)", lambda m: _ESCAPES.get(m.group(1), m.group(1)), text[1:-1])
    if match.lastgroup == "number":
        if re.fullmatch(r"-?\d{1,20}", text):
            return int(text)
        return float(text)
    return _WORDS[text] if text in _WORDS else text.removeprefix("^")


def literal_text(value: Value | None, quoted: bool = False) -> str:
    """A value as it can be typed again; names of enum values stay bare, unless ``quoted``."""
    match value:
        case None:
            return "missing"
        case bool():
            return "true" if value else "false"
        case str():
            if not quoted and _LITERAL.fullmatch(value) and value not in _WORDS:
                return value
            escaped = value.replace("\\", "\\\\").replace('"', '\\"')
            return '"' + escaped.replace("\n", "\\n").replace("\t", "\\t") + '"'
    text = jsonable(value)
    if isinstance(text, list | dict):
        return json.dumps(text)
    return text if isinstance(text, str) else repr(text)
