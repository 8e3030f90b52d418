"""What several values have in common that differ by an index: views of copies as one with marks.

The views of ``Station[3]`` and ``Station[4]`` hold the same texts but for their numbers. Of such a
run one *pattern* is kept, in which marks stand for ``i``, ``i + 1`` and the like; the values of all
copies come from it again. A pattern becomes the text of a function of ``i``.
"""

from __future__ import annotations

import re
from collections.abc import Iterator, Sequence
from contextlib import suppress
from dataclasses import dataclass, fields, is_dataclass, replace
from typing import Any

LEAST = 3
"""Fewer copies are as well read one by one."""

_NUMBER = re.compile(r"(\d+)")
_MARK = re.compile(r"⟦(\d+):(-?\d+)⟧")


_REQUIREMENT = "requirement_"


class _DifferError(Exception):
    """Two values differ by more than an index."""


@dataclass(frozen=True)
class Index:
    """A number in a pattern: ``factor * i + offset``."""

    factor: int
    offset: int

    def of(self, index: int) -> int:
        return self.factor * index + self.offset

    def __repr__(self) -> str:
        number = "i" if self.factor == 1 else f"{self.factor} * i"
        sign = "-" if self.offset < 0 else "+"
        return f"{number} {sign} {abs(self.offset)}" if self.offset else number


def _index(text: str) -> Index:
    """The first mark of a text."""
    mark = _MARK.search(text)
    assert mark is not None
    return Index(int(mark[1]), int(mark[2]))


@dataclass(frozen=True)
class Run:
    """Values alike but for an index, which goes from ``first`` to ``last``."""

    pattern: Any
    first: int
    last: int


def runs(values: Sequence[tuple[int, Any]]) -> Iterator[Run]:
    """The runs among values with their indexes, each of which is one more than the last."""
    at = 0
    while at + LEAST <= len(values):
        index, value = values[at]
        end = at + 1
        with suppress(_DifferError):
            pattern = _common(value, values[end][1], index)
            while values[end : end + 1] == [(index + end - at, _at(pattern, index + end - at))]:
                end += 1
        if end - at >= LEAST:
            yield Run(pattern, index, index + end - at - 1)
        at = end


def _common(one: Any, other: Any, index: int) -> Any:
    """The pattern of the values of an index and the next one.

    Raises:
        _DifferError: there is none.
    """
    if type(one) is not type(other):
        raise _DifferError
    if isinstance(one, str):
        return _common_text(one, other, index)
    if isinstance(one, tuple):
        if len(one) != len(other):
            raise _DifferError
        return tuple(_common(a, b, index) for a, b in zip(one, other, strict=True))
    if is_dataclass(one) and not isinstance(one, type):
        names = [f.name for f in fields(one)]
        parts = {n: _common(getattr(one, n), getattr(other, n), index) for n in names}
        return replace(one, **parts)
    if one == other:
        return one
    if isinstance(one, int) and not isinstance(one, bool) and other > one:
        return Index(other - one, one - (other - one) * index)
    raise _DifferError


def _common_text(one: str, other: str, index: int) -> str:
    if "⟦" in one:
        raise _DifferError  # a user's own
    if one == other:
        return one
    parts, others = _NUMBER.split(one), _NUMBER.split(other)
    if parts[::2] != others[::2]:
        raise _DifferError
    for at in range(1, len(parts), 2):
        if parts[at] != others[at]:
            is_fraction = parts[at - 1].endswith(".") or parts[at + 1].startswith(".")
            step = int(others[at]) - int(parts[at])
            # A `for` with several requirements takes as many of their numbers for each index.
            if is_fraction or step < 1 or (step > 1 and not parts[at - 1].endswith(_REQUIREMENT)):
                raise _DifferError
            parts[at] = f"⟦{step}:{int(parts[at]) - step * index}⟧"
    return "".join(parts)


def _at(pattern: Any, index: int) -> Any:
    """The value of an index."""
    if isinstance(pattern, str):
        return _MARK.sub(lambda mark: str(_index(mark[0]).of(index)), pattern)
    if isinstance(pattern, Index):
        return pattern.of(index)
    if isinstance(pattern, tuple):
        return tuple(_at(part, index) for part in pattern)
    if is_dataclass(pattern) and not isinstance(pattern, type):
        parts = {f.name: _at(getattr(pattern, f.name), index) for f in fields(pattern)}
        return replace(pattern, **parts)
    return pattern


# --- patterns as Python --------------------------------------------------------------------------

_WORD = r"(?:\w|⟦\d+:-?\d+⟧)*"
_TOKEN = re.compile(
    r'(?P<plain>"""(?:.|\n)*?"""|\#[^\n]*)'
    r"""|(?P<string>"(?:[^"\\\n]|\\.)*"|'(?:[^'\\\n]|\\.)*')"""
    rf"|self\.(?P<attribute>{_WORD})"
    rf"|(?P<name>[A-Za-z_]{_WORD})"
    r"|(?P<number>⟦\d+:-?\d+⟧)"
)
_OWN_INDEX = re.compile(r" \(\w+ = ⟦1:0⟧\)")
_METHOD = re.compile(r'    def \w+\(self.*\):\n(?:        """.*"""\n)?')


def in_function(text: str) -> tuple[str, tuple[tuple[str, str], ...]]:
    """Python text with marks as that of a function of ``i``; and its names of attributes.

    What is an attribute of the controller for each copy is read and written by its name, which is
    a constant of the function: ``self.station_3`` becomes ``state[STATION_I]``.
    """
    names: dict[str, str] = {}

    def written(token: re.Match[str]) -> str:
        found = token[0]
        if "⟦" not in found:
            return found
        if token["plain"]:
            found = _OWN_INDEX.sub("", found)
            return _MARK.sub(lambda mark: repr(_index(mark[0])), found)
        if token["string"]:
            return _formatted(found)
        if token["attribute"]:
            constant = _identifier(token["attribute"]).upper()
            names[constant] = _formatted(f'"{token["attribute"]}"')
            return f"state[{constant}]"
        if token["name"]:
            return _identifier(found)
        number = _index(found)
        return f"({number})" if number.offset else "i"

    changed = _TOKEN.sub(written, text)
    starts = [m.start() for m in re.finditer(r"^    def ", changed, re.MULTILINE)]
    pieces = [changed[a:b] for a, b in zip([0, *starts], [*starts, None], strict=True)]
    return "".join(map(_with_state, pieces)), tuple(names.items())


def _formatted(string: str) -> str:
    """A string with marks as one that Python fills in."""
    text = string.replace("{", "{{").replace("}", "}}")
    return "f" + _MARK.sub(lambda mark: f"{{{_index(mark[0])}}}", text)


def _identifier(name: str) -> str:
    """``station_i``, ``station_i_minus_1``."""

    def word(mark: re.Match[str]) -> str:
        index = _index(mark[0])
        factor = "" if index.factor == 1 else str(index.factor)
        sign = "minus" if index.offset < 0 else "plus"
        return f"{factor}i_{sign}_{abs(index.offset)}" if index.offset else f"{factor}i"

    return _MARK.sub(word, name)


def _with_state(method: str) -> str:
    """A method that begins with its state at hand, if it uses it."""
    if "state[" not in method:
        return method
    return _METHOD.sub(lambda head: f"{head[0]}        state = self.__dict__\n", method, count=1)
