"""Which robots would go on with their last command when the node ends."""

from __future__ import annotations

import pytest
from model_text import faults

from robosc.model.resolve import load
from robosc.model.ros.definitions import MessageDefinitions
from robosc.source import Source


def told(provide: str, more: str = "", type_: str = "double") -> list[str]:
    text = f"""
    datatype object Speed {{ x: double n: integer label: string on_: boolean }}
    interface speed use Speed from nowhere_msgs
    component Eye {{
        outgoing message scan with timeout: 1 s, type: double
        behaviour {{
            variable far: double
            initial marked state on {{ on response from scan do far := value }}
        }}
    }}
    component Base {{
        incoming message drive with type: {type_} {"links speed" * (type_ == "Speed")}
        incoming message halt with type: none
    }}
    requirement drive needs scan.fresh
    {provide}
    {more}
    """
    return [text for code, text in faults(text) if code == "no-stop"]


@pytest.mark.parametrize(
    ("data", "type_"),
    [
        ("0.3", "double"),
        ("Eye.far", "double"),
        ("3", "integer"),
        ("{ x: -0.2 }", "Speed"),
        ("{ n: 2 }", "Speed"),
    ],
)
def test_numbers_without_a_stop_are_told(data: str, type_: str) -> None:
    provide = f"provide drive with {data}"
    assert told(provide, type_=type_) == [provide]
    assert told(provide, "stop with halt", type_) == []


@pytest.mark.parametrize(
    ("data", "type_"),
    [
        ("0.0", "double"),
        ("0", "integer"),
        ("{}", "Speed"),
        ("{ x: 0.0, n: 0 }", "Speed"),
        ('{ label: "go", on_: true }', "Speed"),
        ("true", "boolean"),
    ],
)
def test_a_robot_that_sends_no_numbers_needs_no_stop(data: str, type_: str) -> None:
    assert told(f"provide drive with {data}", type_=type_) == []


def test_it_is_told_once() -> None:
    first = "provide drive with 1.0 if Eye.far > 2"
    assert told(first, "provide drive with 0.5 if Eye.far <= 2") == [first]


def test_a_robot_may_stop_with_nothing() -> None:
    assert told("provide drive with 0.3", "stop with nothing") == []
    assert faults("stop with nothing stop with nothing")[0][0] == "several-stops"


def test_a_message_named_nothing_is_meant_where_there_is_one() -> None:
    def robot(messages: str) -> list[str]:
        text = f"component C {{ {messages} }} stop with nothing"
        return [code for code, _ in faults(text)]

    assert robot("outgoing message nothing with type: none") == ["stop-not-a-message"]
    assert robot("incoming message nothing with type: none") == []


@pytest.mark.parametrize("other", ["", "stop: none, "])
def test_a_topic_that_moves_nothing_needs_no_stop(other: str) -> None:
    """It is said of the topic: once for all messages on it, and for no other topic."""
    text = f"""
    component Base {{
        incoming message dim with identifier: "/lights", stop: none, type: double
        incoming message glare with identifier: "lights", type: double
        incoming message drive with {other}type: double
    }}
    provide glare with 1.0
    provide dim with 0.2
    provide drive with 0.4
    """
    found = [shown for code, shown in faults(text) if code == "no-stop"]
    assert found == ([] if other else ["provide drive with 0.4"])


@pytest.mark.parametrize(
    ("requirement", "told_of"),
    [
        ("requirement all needs scan.fresh", True),
        ("requirement { drive, halt } needs scan.fresh", True),
        ("requirement scan.silent disables Base", True),
        ("requirement all except halt needs scan.fresh", False),
        ("requirement { halt, light } needs scan.fresh", False),
        ("requirement drive needs scan.fresh requirement halt needs scan.fresh", False),
    ],
)
def test_what_stops_the_robot_is_not_forbidden_with_what_moves_it(
    requirement: str, told_of: bool
) -> None:
    robot = f"""
    component Eye {{ outgoing message scan with timeout: 1 s, type: double }}
    component Base {{
        incoming message drive with type: double
        incoming message halt with type: none
    }}
    component Lamp {{ incoming message light with stop: none, type: boolean }}
    {requirement}
    provide drive with 0.4
    """
    found = [
        shown for code, shown in faults(f"{robot} stop with halt") if code == "stop-restricted"
    ]
    assert found == [requirement] * told_of
    assert "stop-restricted" not in [code for code, _ in faults(f"{robot} stop with nothing")]
    # A supervisor sends the stop by itself.
    source = Source("model.rscd", f"robot Test {{ {robot} stop with halt }}")
    _, diagnostics = load(source, definitions=MessageDefinitions(), supervises=True)
    assert "stop-restricted" not in [d.code for d in diagnostics]
