"""What people write who know ROS, Python or state charts: one error each, and its edit is right."""

from __future__ import annotations

import pytest
from syntax_support import mistaken, read, told

from robosc.remedies import Change, Remedy

GOOD = """
robot Rover {
    component Laser {
        outgoing message scan with identifier: "/scan", timeout: 0.5 s, type: sensor_msgs/LaserScan
        behaviour {
            variable front: double
            initial marked state on {
                on response from scan do front := value.ranges[0]
            }
        }
    }
    component Base {
        incoming message move with identifier: "/cmd_vel", type: geometry_msgs/Twist
        incoming message halt with identifier: "/cmd_vel", type: geometry_msgs/Twist
    }
    component Lamp {
        service light with identifier: "/light", type: std_srvs/SetBool
        behaviour {
            initial marked state off { on request to light goto busy }
            state busy {
                on response from light goto off
                on error from light goto off
                after 3 s goto off
            }
        }
    }
    requirement move needs scan.fresh
    prefer move over halt
    provide move with { linear: { x: 0.2, y: 0.0 } } if scan.fresh
    provide light with { data: true }
    stop with halt
}
"""
NO_BRACES = "no braces: 'do' stands before what is assigned, 'goto' before a state"
ENTERING = "what is done on entering a state stands at the transitions to it: on … do … goto …"
NO_CONDITIONAL = "no conditional expression: write two transitions, 'on … if …' and 'on … else …'"
QUALITY = "quality of service is a parameter of the generated node: see its README"

WITH_EDIT = [
    ("move needs scan", "move needs if scan", "if", "leave 'if' out"),
    ("move needs scan", "move() needs scan", "move()", "write 'move'"),
    ("provide light with", "provide light() with", "()", "leave '()' out"),
    ("goto busy", "then goto busy", "then", "leave 'then' out"),
    ("goto busy", "goto state busy", "state", "leave 'state' out"),
    ("y: 0.0 }", "y: 0.0, }", ",", "leave ',' out"),
    ("requirement move", "requirement: move", ":", "leave ':' out"),
    ("requirement move", "requirement safe: move", "safe:", "write '\"safe\"'"),
    ("requirement move", 'requirement "safe": move', ":", "leave ':' out"),
    ("stop with halt", "stop halt", "halt", "write 'with halt'"),
    ("move over halt", "move, halt", ",", "write 'over'"),
    ("move over halt", "move > halt", ">", "write 'over'"),
    ("light with {", "light {", "{", "write 'with {'"),
    ("light with {", "light: {", ":", "write 'with'"),
    ("incoming message halt", "incoming halt", "halt", "write 'message halt'"),
    ("outgoing message scan", "outgoing topic scan", "topic", "write 'message'"),
    ("requirement move needs", "move requires", "move requires", "write 'requirement move needs'"),
    ("requirement move needs", "move only if", "move only if", "write 'requirement move needs'"),
    ("requirement move", "rule move", "rule", "write 'requirement'"),
    ("requirement move needs", "assert", "assert", "write 'requirement always'"),
    ("provide light with", "light with", "light", "write 'provide light'"),
    ("provide light with", "call light with", "call", "write 'provide'"),
    ("std_srvs/SetBool", "SetBool", "SetBool", "write 'std_srvs/SetBool'"),
    ("goto busy", 'goto "busy"', '"busy"', "write 'busy', without quotes"),
    ("timeout: 0.5 s", "timeout: 0.5 sec", "0.5 sec", "write '0.5 s'"),
    ("timeout: 0.5 s", "timeout: 10 Hz", "10 Hz", "write '0.1 s', the time between two"),
    ("value.ranges", "value->ranges", "->", "write '.'"),
    ("} if scan", "} when scan", "when", "write 'if'"),
    ("request to light", "call light", "call light", "write 'request to light'"),
    ("request to light", "request light", "light", "write 'to light'"),
    ("response from light", "success light", "success light", "write 'response from light'"),
    ("response from light", "response light", "light", "write 'from light'"),
    ("error from light", "failure of light", "failure of light", "write 'error from light'"),
    ("response from scan", "message scan", "message scan", "write 'response from scan'"),
    ("on response from scan", "when scan", "when scan", "write on response from scan"),
    ("after 3 s", "on timeout 3 s", "on timeout", "write 'after'"),
    ("after 3 s", "timeout 3 s", "timeout", "write 'after'"),
    ("after 3 s", "wait 3 s", "wait", "write 'after'"),
    ("do front := value.ranges[0]", "front := value.ranges[0]", "front", "write 'do front'"),
    ("goto busy", "next busy", "next", "write 'goto'"),
    ("goto busy", "switch to busy", "switch to", "write 'goto'"),
    ("front := value.ranges[0]", "front++", "front++", "write 'front := front + 1'"),
    ("front := value", "set front to value", "set front to", "write 'front :='"),
    ("front := value", "set front := value", "set front :=", "write 'front :='"),
]  # fmt: skip

TOLD = [
    ("incoming message halt", "output message halt", "output",
     "write 'incoming' if the part receives it, 'outgoing' if it sends it"),
    ("outgoing message scan", "topic scan", "topic",
     "write 'incoming message' if the part receives it, 'outgoing message' if it sends it"),
    ("message scan", "message /scan", "/", "a name has no '/': the name in ROS stands behind 'identifier:'"),
    ("std_srvs/SetBool", "SwitchLight", "SwitchLight",
     "write its package before it: PACKAGE/SwitchLight"),
    ("0.5 s, type", "0.5 s, qos: reliable, type", "qos", QUALITY),
    ("0.5 s, type", "0.5 s, queue_size: 1, type", "queue_size", QUALITY),
    ("x: 0.2, y", "x: 0.2 y", "y", "a ',' is missing before it"),
    ("} if scan", "} unless scan", "unless", "write 'if !(…)'"),
    ("prefer move over halt", "priority move", "priority", "write 'prefer COMMAND over COMMAND'"),
    ("request to light goto", "request to light wait 3 s goto", "wait",
     "write 'goto WAITING', and in that state 'after 3 s goto …'"),
    ("do front := value.ranges[0]", "{ front := value.ranges[0] }", "{", NO_BRACES),
    ("front := value.ranges[0]", "{ front := value.ranges[0] }", "{", NO_BRACES),
    ("goto busy", "if (scan.fresh) { goto busy }", "{", NO_BRACES),
    ("value.ranges[0]", "1 else do front := 2", "do",
     "write one more transition: 'on … else …'"),
    ("value.ranges[0]", "value.ranges[0] > 1 then 1 else 2", "then", NO_CONDITIONAL),
    ("value.ranges[0]", "if value.ranges[0] > 1 then 1 else 2", "if", NO_CONDITIONAL),
    ("front := value.ranges[0]", "publish halt", "publish halt",
     "the controller sends a command whenever it is allowed: write a 'requirement'"),
    ("front := value.ranges[0]", 'print("near")', "print", "'do' only assigns to variables"),
    ("after 3 s", "on timeout", "timeout",
     "write 'timeout from NAME', or 'after 3 s' for the time in a state"),
    ("after 3 s goto off", "on entry do halt", "entry", ENTERING),
    ("after 3 s goto off", "entry: halt", "entry", ENTERING),
]  # fmt: skip


@pytest.mark.parametrize(("right", "wrong", "marked", "hint"), [*WITH_EDIT, *TOLD])
def test_it_is_one_error_at_its_place(right: str, wrong: str, marked: str, hint: str) -> None:
    assert not read(GOOD)[1]
    assert told(read(mistaken(GOOD, right, wrong))[1]) == [(marked, hint)]


@pytest.mark.parametrize(("right", "wrong"), [row[:2] for row in WITH_EDIT])
def test_its_edit_mends_it(right: str, wrong: str) -> None:
    text = mistaken(GOOD, right, wrong)
    _, (found,) = read(text)
    hint = found.advice
    assert isinstance(hint, Remedy)
    new = hint.parts[0] if hint.change is Change.REPLACE else ""
    mended = text[: found.span.start] + new + text[found.span.end :]
    assert not read(mended)[1]
