"""Semantic tokens: what each word is, for editors that colour by meaning."""

from __future__ import annotations

from collections.abc import Iterator
from typing import NamedTuple

from robosc.language.keywords import KEYWORDS, Role
from robosc.language.tokens import INTEGER, NUMBER, STRING, tokenize
from robosc.lsp import outline, positions
from robosc.lsp.analysis import Analysis
from robosc.source import Source

TYPES = (
    "namespace", "class", "struct", "enum", "enumMember", "interface", "property", "variable",
    "event", "parameter", "type", "keyword", "comment", "string", "number", "operator",
)  # fmt: skip
MODIFIERS = ("declaration", "modification")

_NUMBERS = {type_: number for number, type_ in enumerate(TYPES)}
_TYPE_OF = {INTEGER: "number", NUMBER: "number", STRING: "string"}


class _Token(NamedTuple):
    """What colours a place in a text."""

    start: int
    end: int
    type: str
    modifiers: int = 0


def encoded(analysis: Analysis, encoding: positions.Encoding = "utf-16") -> list[int]:
    """Five numbers for each token: line and column from the one before, length, type, modifiers."""
    source = analysis.source
    data: list[int] = []
    line = column = 0
    for token in _tokens(analysis):
        for start, end in _lines(source, token):
            at, from_ = positions.position_of(source, start, encoding)
            length = positions.units(source.text[start:end], encoding)
            before = column if at == line else 0
            data += [at - line, from_ - before, length, _NUMBERS[token.type], token.modifiers]
            line, column = at, from_
    return data


def _lines(source: Source, token: _Token) -> Iterator[tuple[int, int]]:
    """A token may not go over a line end."""
    start = token.start
    if source.text.find("\n", start, token.end) < 0:
        yield start, token.end
        return
    for part in source.text[token.start : token.end].split("\n"):
        if part:
            yield start, start + len(part)
        start += len(part) + 1


def _tokens(analysis: Analysis) -> list[_Token]:
    names = {}
    for occurrence in analysis.index.occurrences:
        modifiers = occurrence.declaration | occurrence.write << 1
        span = occurrence.span
        type_ = outline.KINDS[occurrence.symbol.kind.value].token
        names[span.start] = _Token(span.start, span.end, type_, modifiers)
    found = list(names.values())
    tokens = tokenize(analysis.source)
    text = analysis.source.text
    found += (_Token(c.start, c.end, "comment") for c in tokens.comments)
    for kind, start, end in zip(tokens.kinds, tokens.starts, tokens.ends, strict=True):
        if start in names:
            continue
        type_ = _TYPE_OF.get(kind) or _type_of_word(text[start:end])
        if type_:
            found.append(_Token(start, end, type_))
    return sorted(found)


def _type_of_word(word: str) -> str:
    keyword = KEYWORDS.get(word)
    if keyword is None or Role.VALUE in keyword.roles:
        return ""
    return "type" if Role.TYPE in keyword.roles else "keyword"
