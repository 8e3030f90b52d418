"""What is told to those who spell types of ROS as elsewhere, or mistake a direction."""

from __future__ import annotations

from pathlib import Path

import pytest
from ros_support import REPOSITORY

from robosc.model.resolve import load
from robosc.source import Source

FOLDER = REPOSITORY / "robosc_ros1" / "test" / "faulty"
"""The packages in it are found by models in it."""
MODEL = """
robot R {
    component S {
        outgoing message scan with timeout: 1 s, type: example_msgs/Scan
        outgoing message turned with type: example_msgs/Turn
        behaviour {
            initial marked state on { on response from scan goto on }
        }
    }
    component M {
        incoming message go with identifier: "/go", type: none
        incoming message halt with identifier: "/go", type: none
    }
    requirement go needs S.on
    requirement halt needs scan.fresh
    prefer go over halt
    stop with halt
}
"""


@pytest.mark.parametrize(
    ("right", "wrong", "marked", "hint"),
    [
        ("type: example_msgs/Turn", "type: Turn", "Turn", "write example_msgs/Turn"),
        ("type: example_msgs/Turn", "type: example_msgs.Turn", "example_msgs.Turn",
         "write 'example_msgs/Turn'"),
        ("needs S.on", "needs S = on", "S = on", "write 'S.on'"),
        ("needs S.on", "needs S != on", "S != on", "write '!S.on'"),
        ("needs S.on", "needs S.fresh", "S.fresh", "write scan.fresh"),
        ("go needs", "go.request needs", "go.request", "write 'go'"),
    ],
)  # fmt: skip
def test_one_error_with_its_remedy(right: str, wrong: str, marked: str, hint: str) -> None:
    assert told(MODEL) == []
    assert told(MODEL.replace(right, wrong, 1)) == [(marked, hint)]


def test_each_misdirected_command_is_told_once() -> None:
    """At its first use; nothing is said of the topic that both would be received on."""
    text = MODEL.replace("incoming", "outgoing")
    sent = "what the controller publishes is incoming: incoming message"
    assert told(text) == [("go", f"{sent} go"), ("halt", f"{sent} halt")]


def told(text: str) -> list[tuple[str, str]]:
    """The text that each diagnostic marks, and its hint."""
    _, found = load(Source(str(Path(FOLDER, "m.rscd")), text))
    return [(one.span.text, str(one.hint)) for one in found]
