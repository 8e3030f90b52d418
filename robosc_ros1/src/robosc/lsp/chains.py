"""Names with dots in unfinished text, and what the variables of aggregates stand for there.

A chain is a list of names, ``[]`` for an index: ``value.a[0].b`` is value, a, [], b.
"""

from __future__ import annotations

from collections.abc import Sequence

from robosc.lsp.context import Context

_CLOSING = {"(": ")", "[": "]", "{": "}"}


def names_before(words: Sequence[str]) -> list[str]:
    """The chain before the last dot: ``value.a[0].`` gives value, a, []."""
    found: list[str] = []
    place = len(words) - 2
    while place >= 0:
        if words[place] == "]" and "[" in words[:place]:
            found.append("[]")
            place -= words[place::-1].index("[") + 1
            continue
        found.append(words[place].lstrip("^"))
        if place == 0 or words[place - 1] != ".":
            break
        place -= 2
    return found[::-1]


def aggregate_variables(context: Context) -> dict[str, list[str]]:
    """The variables of the aggregates around a place, each with the chain of one element.

    In ``any(d.| for d in value.seen[1..3])`` d is value, seen, [].
    """
    words = (*context.words, *context.ahead)
    found: dict[str, list[str]] = {}
    closed = 0
    for place in reversed(range(len(context.words))):
        if words[place] in _CLOSING.values():
            closed += 1
        elif words[place] in _CLOSING and closed:
            closed -= 1
        elif words[place] == "(":
            begin = _for_of(words, place + 1)
            if begin is not None:
                found[words[begin + 1].lstrip("^")] = _element(words[begin + 3 :])
    return found


def _for_of(words: Sequence[str], begin: int) -> int | None:
    """The place of ``for NAME in``, in the parenthesis that is open at ``begin``."""
    opened = 0
    for place in range(begin, len(words) - 3):
        if words[place] in _CLOSING:
            opened += 1
        elif words[place] in _CLOSING.values():
            opened -= 1
            if opened < 0:
                break
        elif words[place] == "for" and words[place + 2] == "in" and not opened:
            return place
    return None


def _element(words: Sequence[str]) -> list[str]:
    """The chain of one element of the array, list or components that these words begin with."""
    if words[0] == "[":
        return _chain(words[1:])
    return [*_chain(words), "[]"]


def _chain(words: Sequence[str]) -> list[str]:
    """The chain that words begin with; a slice is as the whole array."""
    found = [words[0].lstrip("^")] if words else []
    place = 1
    while place < len(words) - 1:
        if words[place] == ".":
            found.append(words[place + 1].lstrip("^"))
            place += 2
        elif words[place] == "[" and "]" in words[place:]:
            end = words.index("]", place)
            found += [] if ".." in words[place:end] else ["[]"]
            place = end + 1
        else:
            break
    return found
