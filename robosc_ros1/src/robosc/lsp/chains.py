"""Names with dots in unfinished text, and what the variables of aggregates stand for there.

A chain is a list of names, ``[]`` for an index: ``value.a[0].b`` is value, a, [], b.
"""

from __future__ import annotations

from collections.abc import Sequence

from robosc.lsp.completion.context import Context

_CLOSING = {"(": ")", "[": "]", "{": "}"}


def names_before(words: Sequence[str]) -> list[str]:
    """The chain before the last dot: ``value.a[0].`` gives value, a, []."""
    names: list[str] = []
    place = len(words) - 2
    while place >= 0:
        if words[place] == "]" and "[" in words[:place]:
            names.append("[]")
            place -= words[place::-1].index("[") + 1
            continue
        names.append(words[place].lstrip("^"))
        if place == 0 or words[place - 1] != ".":
            break
        place -= 2
    return names[::-1]


def aggregate_variables(context: Context) -> dict[str, list[str]]:
    """The variables of the aggregates around a place, each with the chain of one element.

    A position, which is a number, has none.

    In ``any(d.| for d in value.seen[1..3])`` d is value, seen, [].
    """
    words = (*context.words, *context.ahead)
    variables: dict[str, list[str]] = {}
    closed = 0
    for place in reversed(range(len(context.words))):
        if words[place] in _CLOSING.values():
            closed += 1
        elif words[place] in _CLOSING and closed:
            closed -= 1
        elif words[place] in ("(", "["):
            begin = _for_of(words, place + 1)
            if begin is not None:
                behind = words.index("in", begin)
                variables[words[behind - 1].lstrip("^")] = _element(words[behind + 1 :])
                if behind > begin + 2:
                    variables[words[begin + 1].lstrip("^")] = []
    return variables


def _for_of(words: Sequence[str], begin: int) -> int | None:
    """The place of ``for NAME in`` or ``for NAME, NAME in``, in the bracket open at ``begin``."""
    opened = 0
    for place in range(begin, len(words) - 3):
        if words[place] in _CLOSING:
            opened += 1
        elif words[place] in _CLOSING.values():
            opened -= 1
            if opened < 0:
                break
        elif (
            words[place] == "for"
            and not opened
            and "in" in (words[place + 2], *words[place + 4 : place + 5])
        ):
            return place
    return None


def _element(words: Sequence[str]) -> list[str]:
    """The chain of one element of the array, list or components that these words begin with."""
    if words[0] == "[":
        chain, begin = _chain(words[1:]), _for_of(words, 1)
        behind = 0 if begin is None else words.index("in", begin)
        if begin is not None and chain[:1] == [words[behind - 1].lstrip("^")]:
            return [*_element(words[behind + 1 :]), *chain[1:]]
        return chain
    return [*_chain(words), "[]"]


def _chain(words: Sequence[str]) -> list[str]:
    """The chain that words begin with; a slice is as the whole array."""
    chain = [words[0].lstrip("^")] if words else []
    place = 1
    while place < len(words) - 1:
        if words[place] == ".":
            chain.append(words[place + 1].lstrip("^"))
            place += 2
        elif words[place] == "[" and "]" in words[place:]:
            end = words.index("]", place)
            chain += [] if ".." in words[place:end] else ["[]"]
            place = end + 1
        else:
            break
    return chain
