"""What is told to those who spell types of ROS as elsewhere, or mistake a direction."""

from __future__ import annotations

from pathlib import Path

import pytest
from ros_support import REPOSITORY
from syntax_support import mistaken, told

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
    assert checked(MODEL) == []
    assert checked(mistaken(MODEL, right, wrong)) == [(marked, hint)]


GRAB = """
robot R {
    component Laser {
        outgoing message scan with timeout: 1 s, type: sensor_msgs/LaserScan
        behaviour {
            variable front: double = 0.0
            initial marked state on { on response from scan do front := value.ranges[0] else 0 }
        }
    }
    component Arm {
        service grab with identifier: "/grab", type: std_srvs/Trigger
        behaviour {
            initial marked state open { on request to grab goto busy }
            state busy { on response from grab goto open on error from grab goto open }
        }
    }
    component Base { incoming message move with identifier: "/go", type: geometry_msgs/Twist }
    requirement move needs scan.fresh and Laser.front > 0.3
    requirement grab needs scan.fresh
    provide move with { linear: { x: 0.2 } }
    stop with move
}
"""
ABOUT_VALUE = "write 'value', in a transition on the message"


@pytest.mark.parametrize(
    ("right", "wrong", "marked", "hint"),
    [
        ("value.ranges[0]", "msg.ranges[0]", "msg", ABOUT_VALUE),
        ("value.ranges[0]", "msg.range_max", "msg", ABOUT_VALUE),
        ("value.ranges[0]", "scan.value.ranges[0]", "scan.value.ranges[0]",
         "write 'value.ranges[0]', in a transition on scan"),
        ("value.ranges[0]", "self.front + 1", "self.front", "write 'front'"),
        ("value.ranges[0]", "value.ranges(0)", "value.ranges",
         "an element is in brackets: value.ranges[…]"),
        ("value.ranges[0]", "value.ranges.length", "length", "write length(value.ranges)"),
        ("goto busy", "goto Arm.busy", "Arm.busy", "write 'busy'"),
        ("Laser.front >", "Laser.front =>", "0.3", "'=>' means 'implies': write >= to compare"),
        ("scan.fresh", "grab.active", "grab.active", "write grab.idle or grab.busy"),
        ("scan.fresh", "Arm.state = busy", "state",
         "a state is a condition by itself, such as Arm.open"),
        ("needs scan.fresh", "needs if (scan.fresh)", "if", "leave 'if' out"),
        ("{ linear: { x: 0.2 } }", "{ x: 0.2 }", "x",
         "write linear: { x: … } or angular: { x: … }"),
        ("x: 0.2", 'x: "0.2"', '"0.2"', "write '0.2', without quotes"),
        ("{ linear: { x: 0.2 } }", "Twist(0.2)", "Twist",
         "data is written in braces: { NAME: …, NAME: … }"),
        ("variable front: double = 0.0", "double := 0.0", "double",
         "write 'variable NAME: double = …'"),
        ("variable front: double = 0.0", "variable double := 0.0", ":=",
         "write 'variable NAME: double = …'"),
        ("variable front: double = 0.0", "variable front := 0.0", ":=",
         "write 'variable front: double = …'"),
        ("variable front: double = 0.0", "front := 0.0", "front",
         "write 'variable front: double = …'"),
    ],
)  # fmt: skip
def test_one_error_about_names(right: str, wrong: str, marked: str, hint: str) -> None:
    assert checked(GRAB) == []
    assert checked(mistaken(GRAB, right, wrong)) == [(marked, hint)]


LAMP = """
robot R {
    component Lamp {
        outgoing message bright with timeout: 1 s, type: double
        incoming message glow with type: boolean
        behaviour {
            variable dark: boolean
            initial marked state on_ { on response from bright do dark := value < 0.5 }
        }
    }
    requirement glow needs bright.fresh
    provide glow with Lamp.dark
    stop with nothing
}
"""


@pytest.mark.parametrize(
    ("right", "wrong", "marked", "hint"),
    [
        ("value < 0.5", "value.data < 0.5", "data", "it is the value itself: write value"),
        ("with Lamp.dark", "with { data: Lamp.dark }", "{", "write the value alone: Lamp.dark"),
    ],
)
def test_a_message_of_one_field_is_its_value(
    right: str, wrong: str, marked: str, hint: str
) -> None:
    assert checked(LAMP) == []
    assert checked(mistaken(LAMP, right, wrong)) == [(marked, hint)]


def test_each_misdirected_command_is_told_once() -> None:
    """At its first use; nothing is said of the topic that both would be received on."""
    text = MODEL.replace("incoming", "outgoing")
    sent = "what the controller publishes is incoming: incoming message"
    assert checked(text) == [("go", f"{sent} go"), ("halt", f"{sent} halt")]


def checked(text: str) -> list[tuple[str, str | None]]:
    _, found = load(Source(str(Path(FOLDER, "m.rscd")), text))
    return told(found)
