"""What the indentation of lines says about blocks whose braces are missing."""

from __future__ import annotations

from robosc.syntax.parse_state import ParseState


def is_nested(reading: ParseState, at: int, header: int) -> bool:
    """Whether a token begins its line, indented further than the line of a header."""
    inner, outer = _before(reading, at), _before(reading, header)
    indent = len(outer.expandtabs()) - len(outer.lstrip().expandtabs())
    return not inner.strip() and len(inner.expandtabs()) > indent


def outdented(reading: ParseState, header: int, opening: int, end: int) -> int:
    """The first token behind an opening brace that stands as far left as the block's header.

    ``end`` if there is none before, or the contents of the block are not indented. Closing braces
    do not count.
    """
    lines = [at for at in range(opening + 1, end) if not _before(reading, at).strip()]
    if not lines or not is_nested(reading, lines[0], header):
        return end
    left = (a for a in lines if reading.kind(a) != "}" and not is_nested(reading, a, header))
    return next(left, end)


def is_outdented(reading: ParseState, header: int, opening: int, at: int) -> bool:
    """Whether a token begins a line as far left as its block's header, unlike the first line."""
    if _before(reading, at).strip() or is_nested(reading, at, header):
        return False
    lines = (a for a in range(opening + 1, at) if not _before(reading, a).strip())
    first = next(lines, at)
    return first < at and is_nested(reading, first, header)


def unclosed(reading: ParseState, header: int, end: int) -> tuple[int, int, int] | None:
    """The block from ``header`` on whose closing brace is missing, as the indentation tells: the
    token where its line begins, that of its opening brace, and the brace that closes an outer one.

    None if all braces that begin a line stand below the line with the brace that they close.
    """
    lefts: list[tuple[int, int, int]] = []
    line = header
    for at in range(header, end):
        kind = reading.kind(at)
        if at > header and reading.tokens.begins_line(at):
            line = at
        if kind == "{":
            lefts.append((_left(reading, line), line, at))
        elif kind == "}" and lefts:
            left, begin, opening = lefts.pop()
            if line == at and _left(reading, at) < left:
                outer = any(_left(reading, at) == column for column, _, _ in lefts)
                return (begin, opening, at) if outer else None
    return None


def _left(reading: ParseState, at: int) -> int:
    """Return the column of a line's first token."""
    return len(_before(reading, at).expandtabs())


def _before(reading: ParseState, at: int) -> str:
    """The text before a token on its line."""
    text, end = reading.source.text, reading.tokens.offset(at)
    return text[text.rfind("\n", 0, end) + 1 : end]
