"""Which command a message means, whatever else it carries and however exactly its fields can."""

from __future__ import annotations

import math
import struct
from collections.abc import Sequence
from typing import Any

import pytest

from robosc.runtime.core.values import not_finite
from robosc.runtime.judge.matching import CommandPattern, command_patterns, matching_pattern

NAN = float("nan")


class Header:
    __slots__ = ("frame_id", "seq", "stamp")

    def __init__(self, seq: int = 0) -> None:
        self.seq, self.stamp, self.frame_id = seq, seq / 10, "base"


# What tells a header is its type, as the bindings of both versions of ROS have it.
Header.__module__ = "std_msgs.msg._Header"


class Drive:
    """A command with the fields of a header beside its own."""

    __slots__ = ("frame_id", "speed", "stamp")

    def __init__(self, speed: float = 0.0, stamp: float = 0.0, frame_id: str = "") -> None:
        self.speed, self.stamp, self.frame_id = speed, stamp, frame_id


class Speed:
    """A message of ROS 1 with single precision."""

    __slots__ = ("header", "limits", "x")

    def __init__(self, x: float = 0.0, seq: int = 0, limits: tuple[float, ...] = ()) -> None:
        self.header, self.limits = Header(seq), list(limits)
        (self.x,) = struct.unpack("<f", struct.pack("<f", x))


class Other:
    """A message of ROS 2."""

    __slots__ = ("from_",)

    def __init__(self, from_: int = 0) -> None:
        self.from_ = from_

    @classmethod
    def get_fields_and_field_types(cls) -> dict[str, str]:
        return {"from_": "int8"}


def make(data: dict[str, Any]) -> Speed:
    return Speed(**data)


def matched(patterns: Sequence[CommandPattern], message: Any) -> str | None:
    pattern = matching_pattern(patterns, message)
    return None if pattern is None else pattern.key


EXACT = command_patterns((("slow", ({"x": 0.1},), None), ("drive", (), None)), make)


def test_exact_data_are_known_as_exactly_as_the_field_is() -> None:
    assert matched(EXACT, Speed(0.1)) == "slow"
    assert matched(EXACT, Speed(0.1001)) == "drive"


def test_when_a_message_was_sent_tells_nothing() -> None:
    assert matched(EXACT, Speed(0.1, seq=7)) == "slow"


def test_every_other_field_counts() -> None:
    assert matched(EXACT, Speed(0.1, limits=(0.0,))) == "drive"


def test_a_field_tells_by_its_values() -> None:
    rows = (("one", (), (("x",), (0.7, 1000.1))), ("two", (), (("x",), (2.0,))))
    patterns = command_patterns(rows, make)
    assert [matched(patterns, Speed(x)) for x in (0.7, 1000.1, 2, 0.71)] == [
        "one", "one", "two", None,
    ]  # fmt: skip


def test_a_field_may_be_called_like_a_word_of_python() -> None:
    rows = (("one", (), (("from",), (1,))), ("two", ({"from_": 2},), None))
    patterns = command_patterns(rows, lambda data: Other(**data))
    assert [matched(patterns, Other(x)) for x in (1, 2, 3)] == ["one", "two", None]


def test_no_number_is_never_exact() -> None:
    assert matched(EXACT, Speed(float("nan"))) == "drive"


def test_fields_that_a_header_has_too_are_data() -> None:
    rows = (("halt", ({"speed": 0.0},), None), ("drive", ({"speed": 2.0, "frame_id": "a"},), None))
    patterns = command_patterns(rows, lambda data: Drive(**data))
    assert matched(patterns, Drive(0.0)) == "halt"
    assert matched(patterns, Drive(2.0, frame_id="a")) == "drive"
    assert matched(patterns, Drive(2.0)) is None
    assert matched(patterns, Drive(0.0, stamp=1.0)) is None


class Point:
    __slots__ = ("name", "x", "y")

    def __init__(self, x: float = 0.0, y: float = 0.0) -> None:
        self.x, self.y, self.name = x, y, ""


class Pose:
    """A message without arrays, whose fields are read all at once."""

    __slots__ = ("goal", "header", "level")

    def __init__(self, x: float = 0.0, y: float = 0.0, level: int = 0, seq: int = 0) -> None:
        self.header, self.goal, self.level = Header(seq), Point(x, y), level


def test_fields_of_fields_count_and_headers_do_not() -> None:
    rows = (("a", ({"x": 1.0}, {"y": 2.0}), None), ("b", ({"level": 3},), None), ("c", (), None))
    patterns = command_patterns(rows, lambda data: Pose(**data))
    messages = [Pose(1.0), Pose(y=2.0, seq=5), Pose(level=3), Pose(1.0, 2.0), Pose(NAN)]
    assert [matched(patterns, m) for m in messages] == ["a", "a", "b", "c", "c"]


@pytest.mark.parametrize("number", [NAN, math.inf, -math.inf])
def test_numbers_that_are_not_finite_are_told_by_their_field(number: float) -> None:
    assert not_finite(Pose(1.0, 2.0, 3)) is None
    assert not_finite(Pose(1.0, number)) == f"goal.y is {number}"
    assert not_finite(Point(number)) == f"x is {number}"
    assert not_finite(Speed(limits=(0.0, number))) == f"limits[1] is {number}"
    assert not_finite(Other(7)) is None
