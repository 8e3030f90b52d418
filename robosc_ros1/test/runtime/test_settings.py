"""The parameters of a node as docs/running.md has them: defaults, and what is refused."""

from __future__ import annotations

import math
from typing import Any

import pytest
from runtime.lamp_robot import ARM, GO, HALT, LAMP, LampController

from robosc.runtime.core.model import Parameter
from robosc.runtime.core.settings import ParameterError, Settings, declared, flatten, read

COMMUNICATIONS = LampController.COMMUNICATIONS
DEFAULTS = {
    "rate": 10.0, "order": "rotate", "seed": 0, "on_mismatch": "ignore", "stop_command": "",
    "exit_on_stop": False, "refuse_not_finite": True, "server_lost_after": 5.0, "state_rate": 20.0, "publish_events": True,
    "publish_values": False, "tolerance": 0.05, "whole_values": False,
    "event_log": "", "event_log_size": 10.0, "event_log_files": 5, "legacy_state_topic": "",
    "allowed_publishers": "", "shadow": False, "operate": False,
    "rate/go": 0.0, "rate/halt": 0.0, "rate/light": 0.0, "rate/reach": 0.0,
    "timeout/light": 5.0, "timeout/reach": 5.0, "goal_timeout/reach": 0.0,
}  # fmt: skip

RIGHT: dict[str, list[Any]] = {
    "number": [1, 2.5, 1000.0],
    "integer": [1, 3],
    "boolean": [True, False],
    "string": [""],
}
WRONG: dict[str, list[Any]] = {
    "number": ["10", "fast", True, None, [1.0], math.nan, math.inf, -math.inf, -1.0],
    "integer": ["1", 1.0, True, None, [1], math.nan],
    "boolean": ["true", 1, 0, None, [True]],
    "string": [1, 2.0, True, None, ["a"]],
}


def test_the_defaults() -> None:
    assert {p.name: p.default for p in declared(COMMUNICATIONS)} == DEFAULTS
    settings, warnings = read(COMMUNICATIONS, {})
    assert warnings == []
    assert settings == Settings(
        timeout={LAMP: 5.0, ARM: 5.0},
        goal_timeout={ARM: 0.0},
        rates=dict.fromkeys((GO, HALT, LAMP, ARM), 0.0),
    )
    assert settings.goal_timeout_of(ARM) is None


def test_each_command_may_have_a_rate_of_its_own() -> None:
    settings, warnings = read(COMMUNICATIONS, {"rate": 2.0, "rate/halt": 5})
    assert warnings == []
    assert (settings.rate_of(GO), settings.rate_of(HALT)) == (2.0, 5.0)


@pytest.mark.parametrize("name", ["rate", "event_log_files", "rate/go"])
@pytest.mark.parametrize("value", [10**400, -(10**400), 10**5000], ids=["high", "low", "long"])
def test_an_integer_that_ros_cannot_carry_is_refused(name: str, value: int) -> None:
    with pytest.raises(ParameterError) as refused:
        read(COMMUNICATIONS, {name: value})
    number, integer = "a number that a double can hold", "an integer of at most 64 bits"
    kind = integer if name == "event_log_files" else number
    text = str(refused.value)
    assert text.startswith(f"parameter ~{name} must be {kind}, not ")
    assert len(text) < 200


def test_an_integer_has_at_most_64_bits() -> None:
    seed = Parameter("wide", "integer", 1, "parameter wide of the model")
    for value in (2**63 - 1, -(2**63)):
        for given in (value, str(value)):
            assert read(COMMUNICATIONS, {"wide": given}, [seed])[0].more == {"wide": value}
    for value in (2**63, -(2**63) - 1):
        for given in (value, str(value)):
            with pytest.raises(ParameterError, match="~wide must be an integer of at most 64 bits"):
                read(COMMUNICATIONS, {"wide": given}, [seed])


def test_a_wide_integer_that_came_as_text_is_a_number() -> None:
    given = {"server_lost_after": "5000000000"}
    assert read(COMMUNICATIONS, given)[0].server_lost_after == 5e9


@pytest.mark.parametrize("digits", [400, 401, 5000])
def test_a_text_of_many_digits_is_refused_as_an_integer_of_the_model(digits: int) -> None:
    many = Parameter("many", "integer", 1, "parameter many of the model", attribute="many")
    with pytest.raises(ParameterError, match="parameter ~many must be an integer"):
        read(COMMUNICATIONS, {"many": "1" * digits}, [many])


def test_the_rate_of_all_others_may_stand_in_the_group() -> None:
    """As a tree of ROS 1 has it, where a parameter is either a value or a group."""
    given = flatten({"rate": {"default": 2.0, "halt": 5}})
    settings, warnings = read(COMMUNICATIONS, given)
    assert warnings == []
    assert (settings.rate_of(GO), settings.rate_of(HALT)) == (2.0, 5.0)


@pytest.mark.parametrize("parameter", declared(COMMUNICATIONS), ids=lambda p: p.name)
def test_each_is_checked(parameter: Any) -> None:
    for value in parameter.choices or RIGHT[parameter.type]:
        read(COMMUNICATIONS, {parameter.name: value})
    wrong = WRONG[parameter.type] + (["sideways"] if parameter.choices else [])
    if parameter.minimum is not None:
        read(COMMUNICATIONS, {parameter.name: type(parameter.default)(parameter.minimum)})
        wrong = [*wrong, parameter.minimum - 1]
    if parameter.maximum is not None:
        wrong = [*wrong, parameter.maximum * 1e6]
    for value in wrong:
        with pytest.raises(ParameterError) as refused:
            read(COMMUNICATIONS, {parameter.name: value})
        text = str(refused.value)
        assert text.startswith(f"parameter ~{parameter.name} must be ")
        assert text.endswith(f", not {value!r}")
    with pytest.raises(ParameterError, match="not a group with"):
        read(COMMUNICATIONS, {f"{parameter.name}/deep/inside": 1})


def test_a_topic_has_a_name_that_ros_takes() -> None:
    for topic in ("/state", "state", "~/state", "/a/b_2/c"):
        assert read(COMMUNICATIONS, {"legacy_state_topic": topic})[0].legacy_state_topic == topic
    assert read(COMMUNICATIONS, {"legacy_state_topic": "~x"})[0].legacy_state_topic == "~/x"
    for topic in ("/a b", "5x", "/", "~", "a//b", "a/", "/ä", "state\n"):
        with pytest.raises(ParameterError, match="must be the name of a topic, not"):
            read(COMMUNICATIONS, {"legacy_state_topic": topic})


def test_all_faults_are_told_at_once() -> None:
    with pytest.raises(ParameterError) as refused:
        read(COMMUNICATIONS, {"rate": "x", "seed": 1.5, "stop_command": "jump", "order": 1})
    assert [line.split()[1] for line in str(refused.value).splitlines()] == [
        "~rate", "~order", "~seed", "~stop_command",
    ]  # fmt: skip


@pytest.mark.parametrize(
    ("name", "near"),
    [
        ("rat", "rate"),
        ("timout/light", "timeout/light"),
        ("timeout/lite", "timeout/light"),
        ("stop", None),
        ("xyzzy", None),
    ],
)
def test_an_unknown_one_is_told_with_the_nearest(name: str, near: str | None) -> None:
    settings, (warning,) = read(COMMUNICATIONS, {name: "anything"})
    assert settings == read(COMMUNICATIONS, {})[0]
    hint = "" if near is None else f"; did you mean ~{near}?"
    assert warning == f"unknown parameter ~{name} is ignored{hint}"


def test_what_is_no_group_of_parameters() -> None:
    assert flatten({"timeout": {"light": 1, 2: 3}}) == {"timeout/light": 1, "timeout/2": 3}
    for value in (5, "rate: 5", [1], None):
        with pytest.raises(ParameterError, match="parameters below the node's name, not"):
            flatten(value)  # type: ignore[arg-type]
