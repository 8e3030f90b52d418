"""Places in a text: characters here, units of an encoding in the protocol."""

from __future__ import annotations

import pytest
from hypothesis import given
from hypothesis import strategies as st

from robosc.lsp.positions import Encoding, offset_of, position_of
from robosc.source import Source, common_ends

TEXT = st.text(st.sampled_from("ab \n\t{}é€🤖\u2028\x0b"), max_size=40)
ENCODINGS: tuple[Encoding, ...] = ("utf-8", "utf-16", "utf-32")
BYTES = {"utf-8": ("utf-8", 1), "utf-16": ("utf-16-le", 2), "utf-32": ("utf-32-le", 4)}


@given(text=TEXT, offset=st.integers(0, 40), encoding=st.sampled_from(ENCODINGS))
def test_there_and_back(text: str, offset: int, encoding: Encoding) -> None:
    offset = min(offset, len(text))
    source = Source("x.rscd", text)
    position = position_of(source, offset, encoding)
    assert offset_of(source, position, encoding) == offset
    codec, size = BYTES[encoding]
    line = text[:offset].split("\n")[-1]
    assert position == (text[:offset].count("\n"), len(line.encode(codec)) // size)


@pytest.mark.parametrize(
    ("position", "offset"),
    [
        ((0, 0), 0), ((0, 3), 3), ((0, 99), 3), ((1, 0), 4), ((1, 2), 5), ((1, 3), 6), ((1, 99), 6),
        ((2, 0), 7), ((9, 9), 7),
    ],
)  # fmt: skip
def test_places_out_of_range_are_the_nearest(position: tuple[int, int], offset: int) -> None:
    assert offset_of(Source("x.rscd", "abc\n🤖d\n"), position) == offset


def test_inside_of_a_character_is_before_it() -> None:
    assert offset_of(Source("x.rscd", "🤖"), (0, 1)) == 0


@given(st.text("ab", max_size=12), st.text("ab", max_size=12))
def test_common_ends_are_as_long_as_they_can_be(one: str, other: str) -> None:
    head, tail = common_ends(one, other)
    most = min(len(one), len(other))
    assert head == max(n for n in range(most + 1) if one[:n] == other[:n])
    rest = most - head
    assert tail == max(n for n in range(rest + 1) if one[len(one) - n :] == other[len(other) - n :])


@pytest.mark.parametrize("encoding", ENCODINGS)
@pytest.mark.parametrize("offset", [999, 1000, 1001, 1999, 2000, 2001, 4499, 4500])
def test_places_in_a_long_line(offset: int, encoding: Encoding) -> None:
    """They are counted from a mark in the line, not from its beginning."""
    line = "aé🤖" * 1500
    source = Source("x.rscd", f"before\n{line}\nafter\n")
    codec, size = BYTES[encoding]
    position = position_of(source, 7 + offset, encoding)
    assert position == (1, len(line[:offset].encode(codec)) // size)
    assert offset_of(source, position, encoding) == 7 + offset
