"""Values that are typed are made of the language's tokens."""

from __future__ import annotations

import math

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from robosc.simulate.faults import InvalidLine
from robosc.simulate.values.literals import Path, Raw, literal_text, parse_raw, path_in


@pytest.mark.parametrize(
    ("text", "value"),
    [
        ("", None),
        ("  ", None),
        ("4", 4),
        ("-4", -4),
        ("- 4", -4),
        ("0.25", 0.25),
        ("2.5E-4", 2.5e-4),
        ("123456789012345678901", 123456789012345678901.0),
        ("true", True),
        ("missing", None),
        ("free", "free"),
        ("Way.free", "Way.free"),
        ("^state", "state"),
        ("state", "state"),
        ("-Infinity", "-Infinity"),
        ("'a b'", "a b"),
        (r'"a\n\"b\""', 'a\n"b"'),
        ("x: 1, kind = free", {"x": 1, "kind": "free"}),
        ("x: 1 y: 2,", {"x": 1, "y": 2}),
        ("pose.x: -1", {"pose.x": -1}),
        ("ranges[0]: 1", {"ranges[0]": 1}),
        ("ranges: [0.5, null, 1e-3], x: 2", {"ranges": [0.5, None, 1e-3], "x": 2}),
        ('0.4, "A.x < A.y": true', {"": 0.4, '"A.x < A.y"': True}),
        ('"A.x < A.y": false', {'"A.x < A.y"': False}),
    ],
)
def test_what_is_read(text: str, value: Raw) -> None:
    assert parse_raw(text) == value


@pytest.mark.parametrize(
    "text",
    [
        "4x",
        "1.2.3",
        "x:",
        "x: 1 2",
        "x: 1,, y: 2",
        ": 1",
        "x: [1, 2",
        '"a',
        "4,",
        r'"\q"',
        "ä",
        "x:=1",
    ],
)
def test_what_is_not_read(text: str) -> None:
    with pytest.raises(InvalidLine):
        parse_raw(text)


def test_numbers_in_arrays_are_no_texts() -> None:
    """A package's own reader takes what stands in quotes for text."""
    value = [1.0, math.inf, {"a": -math.inf}, math.nan, "NaN"]
    assert literal_text(value) == '[1.0, Infinity, {"a": -Infinity}, NaN, "NaN"]'
    assert repr(parse_raw(literal_text(value))) == repr(value)


@settings(max_examples=100)
@given(
    st.text(max_size=12)
    | st.sampled_from(["true", "missing", "4", "^a", "a.b", "a b", '"a"', "//a"])
)
def test_a_text_that_is_shown_can_be_typed_again(value: str) -> None:
    if value.isprintable():
        assert parse_raw(literal_text(value)) == value


@pytest.mark.parametrize(
    ("text", "path"),
    [
        ("x", ("x",)),
        ("pose.x", ("pose", "x")),
        ("ranges[12].^state", ("ranges", 12, "state")),
        ("", None),
        ("x.", None),
        ("[0]", None),
        ("x[-1]", None),
        ("x[1234567]", None),
        ("x y", None),
    ],
)
def test_paths(text: str, path: Path | None) -> None:
    assert path_in(text) == path
