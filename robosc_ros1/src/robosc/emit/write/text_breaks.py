"""Breaks the long lines of generated files that are not Python: settings, XML and Markdown.

To their readers they are the same: a line end between attributes of XML, or within a paragraph of
Markdown, is a blank.
"""

from __future__ import annotations

import re
from collections.abc import Callable

from robosc.emit.write.line_breaks import WIDTH, filled

_XML_COMMENT = re.compile(r"( *)<!-- .*-->")
_ELEMENT = re.compile(r"( *)(<(\w+)>)(.* .*)(</\3>)")
_TAG = re.compile(r'( *<\w+ )((?:[\w:-]+="[^"]*"[ />?]*)+)')
_ATTRIBUTE = re.compile(r'[\w:-]+="[^"]*"[/>?]*')
_ITEM = re.compile(r" *(?:- )?")
_NO_PROSE = ("|", "#", "<!--", "```")
_JOINED = re.compile(r" (?![A-Za-z(`~/\"])")
"""A blank before what could be markup at the beginning of a line."""


def break_comments(text: str) -> str:
    """The text with no comment (from ``#`` on) longer than :data:`WIDTH` but for its words."""

    def lines(line: str) -> list[str]:
        indent = line[: len(line) - len(line.lstrip())]
        return (
            filled(line.lstrip(), indent, f"{indent}# ")
            if line[len(indent) :][:1] == "#"
            else [line]
        )

    return _each(text, lines)


def break_xml(text: str) -> str:
    """The text with one line for each attribute that would be behind :data:`WIDTH`."""
    return _each(text, _markup)


def _markup(line: str) -> list[str]:
    if match := _XML_COMMENT.fullmatch(line):
        return filled(line.strip(), match[1], f"{match[1]}     ")
    if match := _ELEMENT.fullmatch(line):
        indent, start, _, content, end = match.groups()
        return [indent + start, *filled(content, f"{indent}  ", f"{indent}  "), indent + end]
    if match := _TAG.fullmatch(line):
        attributes = [found.replace(" ", "\0") for found in _ATTRIBUTE.findall(match[2])]
        return filled(" ".join(attributes), match[1], " " * len(match[1]))
    return [line]


def break_markdown(text: str) -> str:
    """The text with all paragraphs and items filled anew.

    Commands in blocks of code get a backslash; tables stay as they are.
    """
    lines: list[str] = []
    block: list[str] = []
    fence = ""
    for line in text.split("\n"):
        is_prose = not fence and line and not line.startswith(_NO_PROSE)
        if block and (not is_prose or line.lstrip().startswith("- ")):
            lines += _paragraph(block)
            block = []
        if is_prose:
            block.append(line)
        elif fence == "```" and len(line) > WIDTH:
            lines += [f"{part} \\" for part in filled(line, "", "    ", WIDTH - 2)]
            lines[-1] = lines[-1].removesuffix(" \\")
        else:
            lines += _markup(line) if len(line) > WIDTH else [line]
        if line.startswith("```"):
            fence = "" if fence else line
    return "\n".join([*lines, *_paragraph(block)])


def _paragraph(block: list[str]) -> list[str]:
    if not block:
        return []
    match = _ITEM.match(block[0])
    assert match is not None
    text = " ".join([block[0][match.end() :], *map(str.strip, block[1:])])
    text = _JOINED.sub("\0", text)
    return filled(text, match[0], " " * match.end())


def _each(text: str, broken: Callable[[str], list[str]]) -> str:
    lines = text.split("\n")
    return "\n".join(
        part for line in lines for part in (broken(line) if len(line) > WIDTH else [line])
    )
