"""Which names ROS allows, and how names of models become names of packages."""

from __future__ import annotations

import pytest
from hypothesis import given
from hypothesis import strategies as st

from robosc.language.keywords import escape
from robosc.names import (
    is_identifier,
    package_name,
    package_name_fault,
    ros_name_fault,
    snake_case,
)


@pytest.mark.parametrize(
    "name",
    ["vel", "/vel", "cmd_vel", "/robot_1/left/cmd_vel", "a/b", "~state", "~/state", "/_a", "A1"],
)
def test_allowed(name: str) -> None:
    assert ros_name_fault(name) is None


@pytest.mark.parametrize(
    ("name", "reason"),
    [
        ("", "it is empty"),
        ("/", "it names no topic"),
        ("~", "it names no topic"),
        ("~/", "it names no topic"),
        ("/vel/", "it ends with '/'"),
        ("a//b", "it contains '//'"),
        ("//a", "it contains '//'"),
        ("1st", "the part '1st' begins with a digit (ROS 2)"),
        ("/a/2", "the part '2' begins with a digit (ROS 2)"),
        ("a__b", "the part 'a__b' contains '__' (ROS 2)"),
        ("_a", "it begins with '_' (ROS 1)"),
        ("a b", "' ' is not allowed: only letters, digits, '_' and '/' are"),
        ("a-b", "'-' is not allowed: only letters, digits, '_' and '/' are"),
        ("a~b", "'~' is not allowed: only letters, digits, '_' and '/' are"),
        ("é", "'é' is not allowed: only letters, digits, '_' and '/' are"),
        ("a\n", "'\\n' is not allowed: only letters, digits, '_' and '/' are"),
    ],
)
def test_refused(name: str, reason: str) -> None:
    assert ros_name_fault(name) == reason


@pytest.mark.parametrize(
    ("name", "snake"),
    [
        ("LineFollower", "line_follower"),
        ("lineFollower", "line_follower"),
        ("line_follower", "line_follower"),
        ("HTTPServer", "http_server"),
        ("Robot2D", "robot2_d"),
        ("A", "a"),
        ("__A__B", "a_b"),
    ],
)
def test_snake_case(name: str, snake: str) -> None:
    assert snake_case(name) == snake


@given(st.from_regex(r"[A-Za-z_][A-Za-z0-9_]*", fullmatch=True))
def test_every_identifier_gives_a_package_name_of_rep_144(name: str) -> None:
    package = package_name(name)
    assert package[0].isalpha()
    assert package == package.lower()
    assert "__" not in package
    assert is_identifier(package)


def test_only_reserved_words_are_escaped() -> None:
    assert [escape(name) for name in ("value", "state", "and")] == ["^value", "state", "^and"]


@pytest.mark.parametrize("text", ["", "1a", "a b", "a-b", "é", "^a", "a\n"])
def test_no_identifiers(text: str) -> None:
    assert not is_identifier(text)


@pytest.mark.parametrize("name", ["line_follower_controller", "r2_d2", "a"])
def test_packages_may_be_called(name: str) -> None:
    assert package_name_fault(name) is None


@pytest.mark.parametrize(
    "name",
    [
        "",
        "1x",
        "Upper",
        "a-b",
        "a b",
        "a/b",
        "../a",
        "é",
        "x.y",
        "a__b",
        "_a",
        "a_",
        "class",
        "json",
    ],
)
def test_packages_cannot_be_called(name: str) -> None:
    assert package_name_fault(name) is not None
