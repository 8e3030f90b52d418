"""Breaks the long lines of generated Python, as formatters do.

Templates write each statement on one line. Of what is longer than :data:`WIDTH` the content of a
bracket goes to lines of its own, operators begin a line, and a comment behind goes above.
"""

from __future__ import annotations

import ast
import io
import re
import tokenize
from collections.abc import Iterator
from itertools import pairwise
from textwrap import wrap

WIDTH = 100
INDENT = "    "
_LEVELS = (
    ("for", "if"),
    (",",),
    ("or",),
    ("and",),
    ("==", "!=", "<", "<=", ">", ">="),
    ("+", "-"),
    ("*", "/", "%"),
)
"""Where an expression is broken, the loosest first; ``for`` and ``if`` are of comprehensions."""
_OPERATORS = frozenset(operator for level in _LEVELS for operator in level)
_OPENING, _CLOSING = ("(", "[", "{"), (")", "]", "}")
_HEAD = re.compile(r"(?:(?:if|elif|return|yield) |[\w.]+ = )(?=.)")
_DOCSTRING = re.compile(r'"""(.*)"""')
_STRING = r"""f?"(?:[^"\\]|\\.)*"|'(?:[^'\\]|\\.)*'"""
_TEXT = re.compile(rf"(?P<head>\w+=|)(?P<text>{_STRING})(?P<tail>,?)")
"""A string literal and nothing else, maybe of an argument."""


def break_long_lines(source: str) -> str:
    """The same program with no line longer than :data:`WIDTH` but for names that are."""
    if all(len(line) <= WIDTH for line in source.split("\n")):
        return source
    within = _within_strings(source)
    lines: list[str] = []
    for number, line in enumerate(source.split("\n"), 1):
        if len(line) <= WIDTH or within.get(number) is False:
            lines.append(line)
        elif number in within:
            indent = line[: len(line) - len(line.lstrip())]
            lines += filled(line.lstrip(), indent, indent)
        else:
            lines += _statement(line)
    return "\n".join(lines)


def unparenthesised(text: str) -> str:
    """An expression without the brackets around the whole of it."""
    while text.startswith("(") and (0, len(text) - 1) in _brackets(text):
        if text == "()" or _has_comma(text[1:-1]):
            break  # a tuple
        text = text[1:-1].strip()
    return text


def _within_strings(source: str) -> dict[int, bool]:
    """The numbers of the lines of strings of several lines, and whether it is a docstring."""
    tokens = tokenize.generate_tokens(io.StringIO(source).readline)
    return {
        line: token.line.lstrip().startswith('"""')
        for token in tokens
        if token.type == tokenize.STRING and token.start[0] != token.end[0]
        for line in range(token.start[0], token.end[0] + 1)
    }


def _statement(line: str) -> list[str]:
    """A line of its own, broken."""
    text = line.lstrip()
    indent = line[: len(line) - len(text)]
    if text.startswith("#"):
        return _comment(text, indent)
    if docstring := _DOCSTRING.fullmatch(text):
        start = f'{indent}"""'
        lines = filled(docstring[1], start, indent, WIDTH - 3)
        return [*lines[:-1], f'{lines[-1]}"""']
    text, comment = _without_comment(text)
    if text.startswith("from "):
        return _import(text, comment, indent)
    head = match[0] if (match := _HEAD.match(text)) else ""
    tail = ":" if head.startswith(("if ", "elif ")) else ""
    body = unparenthesised(text[len(head) :].removesuffix(":") if tail else text[len(head) :])
    above = _comment(comment, indent) if comment else []
    if len(indent + head + body + tail) <= WIDTH:
        return [*above, indent + head + body + tail]
    if head and (len(_pieces(body)) > 1 or _TEXT.fullmatch(body)):
        lines = _expression(body, indent + INDENT)
        return [*above, f"{indent}{head}(", *lines, f"{indent}){tail}"]
    return [*above, *_expression(f"{head}{body}{tail}", indent)]


def _import(text: str, comment: str, indent: str) -> list[str]:
    """An import with a line for each name; its comment, a `noqa`, counts on the first line only."""
    module, _, names = text.partition(" import ")
    behind = f"  {comment}" if comment else ""
    if names.startswith("("):  # the template has a line for each name already
        return [f"{indent}{text}{behind}"]
    lines = [f"{indent}{INDENT}{name}," for name in names.split(", ")]
    return [f"{indent}{module} import ({behind}", *lines, f"{indent})"]


def _comment(text: str, indent: str) -> list[str]:
    return filled(text, indent, f"{indent}#     ")


def filled(text: str, first: str, others: str, width: int = WIDTH) -> list[str]:
    """The words of a text in lines that begin with ``first``, then ``others``.

    At a blank that is written ``\\0`` no line ends.
    """
    lines = wrap(text, width, initial_indent=first, subsequent_indent=others,
                 break_long_words=False, break_on_hyphens=False)  # fmt: skip
    return [line.replace("\0", " ") for line in lines]


def _expression(text: str, indent: str) -> list[str]:
    """A part of what stands in brackets."""
    if len(indent + text) <= WIDTH:
        return [indent + text]
    if match := _TEXT.fullmatch(text):
        return broken_string(match["head"], match["text"], match["tail"], indent)
    pieces = _pieces(text)
    if len(pieces) > 1:
        return [line for piece in pieces for line in _expression(piece, indent)]
    start, end = max(_brackets(text), key=lambda pair: pair[1] - pair[0], default=(0, 0))
    content = text[start + 1 : end].strip()
    if not content:
        return [indent + text]
    if _has_comma(content) and not content.endswith(","):
        content += ","
    inside = _expression(content, indent + INDENT) if end else []
    if len(inside) == 1 and _has_comma(content):
        entries = _pieces(content)
        inside = [line for entry in entries for line in _expression(entry, indent + INDENT)]
    return [indent + text[: start + 1], *inside, indent + text[end:]]


def broken_string(head: str, text: str, tail: str, indent: str) -> list[str]:
    """A long string as several that stand one below the other."""
    inner = indent + INDENT if head else indent
    formatted = text.startswith("f")
    words = re.findall(
        r"(?:\{[^}]*\}|\S)+\s*|\s+" if formatted else r"\S+\s*|\s+",
        text[2:-1] if formatted else ast.literal_eval(text),
    )
    spelled = _formatted if formatted else quoted
    lines = [""]
    for word in words:
        if lines[-1] and len(inner + spelled(lines[-1] + word)) > WIDTH:
            lines.append("")
        lines[-1] += word
    parts = [inner + spelled(line) for line in lines]
    if head:
        return [f"{indent}{head}(", *parts, f"{indent}){tail}"]
    return [*parts[:-1], parts[-1] + tail]


def _formatted(text: str) -> str:
    return f'f"{text}"'


def quoted(text: str) -> str:
    """The text as a string of Python, in double quotation marks where that needs no escapes."""
    written = repr(text)
    return f'"{written[1:-1]}"' if written[0] == "'" and '"' not in written else written


def _pieces(text: str) -> list[str]:
    """The text broken at its loosest operators, each of which begins a piece; commas end one."""
    found = _operators(text)
    for level in _LEVELS:
        places = [at + (name == ",") for name, at in found if name in level]
        if places:
            cuts = [0, *places, len(text)]
            return [piece for a, b in pairwise(cuts) if (piece := text[a:b].strip())]
    return [text]


def _has_comma(text: str) -> bool:
    return any(name == "," for name, _ in _operators(text))


def _tokens(text: str) -> list[tokenize.TokenInfo]:
    """The tokens of a part of a line, whose places are those in the text."""
    try:
        return list(tokenize.generate_tokens(io.StringIO(text).readline))
    except tokenize.TokenError:  # at the end, for a line that leaves a bracket open
        return []


def _nested(text: str) -> Iterator[tuple[tokenize.TokenInfo, int]]:
    """The tokens of a text, each with the number of brackets around it."""
    depth = 0
    for token in _tokens(text):
        depth -= token.string in _CLOSING
        yield token, depth
        depth += token.string in _OPENING


def _operators(text: str) -> list[tuple[str, int]]:
    """The operators and commas outside of all brackets, and where they begin."""
    found = []
    within = parameters = False  # of a lambda
    binary = False  # whether a sign would be an operator here
    outer = {token.string for token, depth in _nested(text) if depth == 0}
    for token, depth in _nested(text):
        name = token.string
        if depth == 0 and name in ("lambda", ",", ":"):
            parameters = name == "lambda" or (parameters and name == ",")
            within = (within and name != ",") or name == "lambda" or parameters
        if (
            depth == 0
            and name in _OPERATORS
            and not within
            and (binary or name not in "+-")
            # The elements of a comprehension have no commas, and its condition no other branch.
            and (name not in ("if", ",") or (name == "if") is ("for" in outer))
        ):
            found.append((name, token.start[1]))
        binary = name in _CLOSING or (
            token.type in (tokenize.NAME, tokenize.NUMBER, tokenize.STRING)
            and name not in ("or", "and", "not", "if", "else", "in")
        )
    return found


def _brackets(text: str) -> list[tuple[int, int]]:
    """Where the outermost brackets begin and end."""
    outer = [token for token, depth in _nested(text) if depth == 0]
    starts = [token.start[1] for token in outer if token.string in _OPENING]
    ends = [token.start[1] for token in outer if token.string in _CLOSING]
    return list(zip(starts, ends, strict=True))


def _without_comment(text: str) -> tuple[str, str]:
    """A statement, and the comment behind it."""
    for token in _tokens(text):
        if token.type == tokenize.COMMENT:
            return text[: token.start[1]].rstrip(), token.string
    return text, ""
