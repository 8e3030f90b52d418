"""What is advised to those who write what other languages have."""

from __future__ import annotations

from collections.abc import Sequence
from itertools import permutations

import pytest
from syntax_support import read

from robosc.errors import listing
from robosc.language.attributes import ATTRIBUTES
from robosc.model.resolve import load
from robosc.source import Source

MODEL = """
robot R {
    component S {
        outgoing message bits with type: integer
        outgoing message level with type: double
        behaviour {
            variable b: integer
            variable f: boolean
            variable l: double
            initial marked state on {
                on response from bits do b := value, f := has(value, 4)
                on response from level do l := value
            }
        }
    }
    component M { incoming message go with type: none }
    %s
}
"""
BITS = "has(number, mask) tells whether bits are set"
NAMING = "write 'condition NAME = …', or 'constant NAME: type = …'"


@pytest.mark.parametrize(
    ("condition", "hint"),
    [
        ("S.b & 4 != 0", f"write 'and'; {BITS}"),
        ("S.b | 4 = 4", f"write 'or'; {BITS}"),
        ("S.f && S.f", "write 'and'"),
        ("S.f || S.f", "write 'or'"),
        ("if S.f", "leave 'if' out"),
        ("if (S.f)", "leave 'if' out"),
        ("S.l > 35%", "write '0.35'"),
        ("S is on", "write 'S.on'"),
        ("S is not on", "write '!S.on'"),
        ("S.f is true", "write '='"),
        ("S.l is not 1", "write '!='"),
        ("S.state = on", "a state is a condition by itself, such as S.on"),
        ("self.l > 0", "write 'l'"),
        ("S.l => 0.3", "'=>' means 'implies': write >= to compare"),
        ('S.l > "0.3"', "write '0.3', without quotes"),
        ("S.l > 1 for 2 s", "name the condition: 'condition NAME = … for 2 s'"),
        ("S.b in (1, 2)", "write the values in braces: x in { a, b }"),
        ("S.b in [1, 2]", "write the values in braces: x in { a, b }"),
        ("S.b in 1..3", "write the values in braces: x in { a, b }"),
        ("S.b not in { 1, 2 }", "write !(x in { a, b })"),
        ("S.l between 0 and 1", "write a <= x and x <= b"),
        ("0 < S.l < 1", "write 0 < S.l and S.l < …"),
        (
            "S.l > 0 ? true : false",
            "there is no conditional expression: use 'provide … if', or 'if' in transitions",
        ),
        ("abs S.l < 1", "write abs(…)"),
        ("Math.abs(S.l) < 1", "write abs(…)"),
        ("pow(S.l, 2) > 1", "write x * x"),
        ("min([S.l, 1]) > 0", "write min(S.l, 1)"),
        ("max(S.l) > 0", "of an array: max(x for x in S.l)"),
    ],
)
def test_expressions_of_other_languages(condition: str, hint: str) -> None:
    assert hint_of(f"requirement go needs {condition}") == hint


@pytest.mark.parametrize(
    ("declaration", "hint"),
    [
        ("let ready = S.f", NAMING),
        ("define ready = S.f", NAMING),
        ("def ready = S.f", NAMING),
        ("macro ready = S.f", NAMING),
        ("const limit: double = 0.5", "did you mean 'constant'?"),
        ("constant limit = 0.5", "write 'constant NAME: type = …'"),
        ("condition ready: boolean = S.f", "write 'condition NAME = …': a condition has no type"),
        ("condition ready { S.f }", "write 'condition NAME = …': a condition has no type"),
        ("var x: double", "a component's behaviour has variables: 'variable NAME: type'"),
    ],
)
def test_declarations_of_other_languages(declaration: str, hint: str) -> None:
    assert hint_of(declaration) == hint


def hint_of(line: str) -> str | None:
    """The hint of the first diagnostic."""
    _, diagnostics = load(Source("m.rscd", MODEL % line))
    return diagnostics[0].hint


def none_of(attribute: str, communication: str) -> str:
    labels = [f"'{a.name}:'" for a in ATTRIBUTES if communication in a.communications]
    return f"there is no '{attribute}:' here, but {listing(labels, 'or')}"


COMMA, TWICE = "a ',' is missing before it", "leave one of them out"
COMMAND = (
    "the controller sends it: only what it receives or requests has a timeout; what the robot"
    " publishes is an 'outgoing message'"
)


@pytest.mark.parametrize(
    ("declaration", "hint"),
    [
        ("outgoing message m with type: double timeout: 3 s", COMMA),
        ("outgoing message m with type: double, timeout 3 s", "write 'timeout:' with its colon"),
        ("outgoing message m with identifier: '/a', identifier: '/m', type: double", TWICE),
        ("outgoing message m with type: double, type: double", TWICE),
        ("outgoing message m with request: double", none_of("request", "outgoing")),
        ("outgoing message m with rate: 10 Hz, type: double", none_of("rate", "outgoing")),
        ("service m with request: none, response: none, feedback: none",
         none_of("feedback", "service")),
        ("service m with request: none, type: p/T", "leave 'request:' or 'type:' out"),
        ("incoming message m with type: none, timeout: 3 s", COMMAND),
        ("incoming message m with type: none timeout: 3 s", COMMAND),
        ("outgoing service m with type: p/T, timeout: 3 s",
         "the controller serves it: only what it receives or requests has a timeout"),
        ("outgoing action m with within: 3 s, type: p/T",
         none_of("within", "outgoing action")),
        ("outgoing message m with identifier: '/m' type: double", "a ',' is missing before it"),
        ("outgoing message m identifier: '/m', type: double", "'with' is missing before it"),
        # What comes before is another communication.
        ("service a with request: none, response: none links l service m timeout: 1 s",
         "'with' is missing before it"),
    ],
)  # fmt: skip
def test_attributes_that_are_not_there(declaration: str, hint: str) -> None:
    interface = "interface l use Trigger from std_srvs"
    text = f"robot R {{ component C {{ {declaration} }} {interface} }}"
    _, found = load(Source("m.rscd", text))
    assert [diagnostic.hint for diagnostic in found if diagnostic.code == "syntax"] == [hint]


@pytest.mark.parametrize(
    ("before", "attributes"),
    [
        ("incoming message", ["identifier: '/m'", "rate: 2 Hz", "stop: none", "type: none"]),
        ("outgoing message", ["identifier: '/m'", "timeout: 1 s", "max_age: 2 s", "type: double"]),
        ("service", ["timeout: 1 s", "request: none", "response: double", "expect: value > 1.0"]),
        ("action", ["within: 1 s", "goals: replace", "request: none", "response: none",
                    "feedback: double"]),
        ("outgoing service", ["identifier: '/m'", "request: none", "response: double"]),
    ],
)  # fmt: skip
def test_attributes_stand_in_any_order(before: str, attributes: list[str]) -> None:
    def tree(order: Sequence[str]) -> tuple[object, list[str]]:
        text = f"robot R {{ component C {{ {before} m with {', '.join(order)} }} }}"
        node, diagnostics = read(text)
        return node, [d.code for d in diagnostics]

    expected = tree(attributes)
    assert expected[1] == []
    for order in permutations(attributes):
        assert tree(order) == expected


@pytest.mark.parametrize("named", ["", 'identifier: "/go", '])
@pytest.mark.parametrize("kind", ["incoming", "outgoing"])
def test_a_timeout_of_a_command(named: str, kind: str) -> None:
    again = "timeout: 1 s, " if kind == "outgoing" else ""
    first = "incoming message a with type: none "
    message = f"{kind} message m with {named}{again}timeout: 3 s, type: none"
    _, (found, *_) = load(Source("m.rscd", f"robot R {{ component C {{ {first}{message} }} }}"))
    assert found.hint == (COMMAND if kind == "incoming" else TWICE)


GOOD = """
robot Rover {
    component Laser {
        outgoing message scan with identifier: "/scan", timeout: 0.5 s, type: double
        outgoing message button with identifier: "/button", type: none
        behaviour {
            variable front: double = 0.0
            initial marked state on { on response from scan do front := value }
        }
    }
    component Motor {
        incoming message move with identifier: "/cmd_vel", type: double
        service grab with request: none, response: none
        behaviour {
            initial marked state resting { on request to move goto moving }
            state moving { on request to grab goto resting }
        }
    }
    requirement move needs scan.fresh and Laser.front > 0.35
    provide move with 0.2
}
"""
LEAVE_OUT = "numbers have no unit: leave it out"
SENT = "what the controller publishes comes into the part"


@pytest.mark.parametrize(
    ("right", "wrong", "marked", "hint"),
    [
        ("incoming message", "publish message", "publish", f"write 'incoming': {SENT}"),
        ("incoming message", "publisher", "publisher", f"write 'incoming message': {SENT}"),
        ("outgoing message scan", "subscribe scan", "subscribe",
         "write 'outgoing message': what the controller subscribes to goes out of the part"),
        ('"/scan"', "/scan", "/scan", 'write "/scan", in quotes'),
        ('"/scan"', "/front/scan", "/front/scan", 'write "/front/scan", in quotes'),
        ('"/cmd_vel"', "cmd_vel", "cmd_vel", 'write "cmd_vel", in quotes'),
        ("type: none", 'type: "std_msgs/Empty"', '"std_msgs/Empty"',
         "write 'std_msgs/Empty', without quotes"),
        ("type: none", "type: 'none'", "'none'", "write 'none', without quotes"),
        ("request: none, response: none", 'type: "std_srvs/Trigger"', '"std_srvs/Trigger"',
         "write 'std_srvs/Trigger', without quotes"),
        ("variable front: double =", "variable front: double :=", ":=",
         "write '=' for an initial value"),
        ("variable front: double =", "variable front double :=", "double",
         "write 'variable front: double = …'"),
        ("variable front: double =", "double front :=", "double",
         "write 'variable front: double = …'"),
        ("variable front: double =", "float front =", "float",
         "write 'variable front: double = …'"),
        ("variable front: double =", "double :=", "double", "write 'variable NAME: double = …'"),
        ("variable front: double =", "front: double =", "front", "write 'variable front'"),
        ("on request to move", "on move", "move", "write 'request to move'"),
        ("on response from scan", "on scan", "scan", "write 'response from scan'"),
        ("on request to grab", "on grab", "grab",
         "write request to grab or response from grab or error from grab"),
        ("on request to move", "on landed", "landed",
         "write 'response from NAME' for what the part sends, 'request to NAME' for a command"),
        ("on request to move", "on reqest to move", "reqest", "did you mean 'request'?"),
        ("goto moving", "-> moving", "->", "write 'goto'"),
        ("variable front:", "variable front-left-near:", "front-left-near",
         "write 'front_left_near': a name has no '-'"),
        ("message scan", "message laser-scan", "laser-scan",
         "write 'laser_scan': a name has no '-'"),
        ("component Laser", "component Laser-Front", "Laser-Front",
         "write 'Laser_Front': a name has no '-'"),
        ("state moving", "state driving-on", "driving-on", "write 'driving_on': a name has no '-'"),
        ("move needs", "move if", "if", "write 'needs'"),
        ("move needs", "move unless", "unless",
         "write 'requirement CONDITION disables COMMAND'"),
        ("identifier", "topic", "topic", "write 'identifier'"),
        ("> 0.35", "> 0.5 m", "m", LEAVE_OUT),
        ("> 0.35", "> 30 deg", "deg", LEAVE_OUT),
        ("> 0.35", "> 0.5m", "0.5m", "write '0.5': numbers have no unit"),
        ("> 0.35", "> 0,35", "0,35", "write '0.35', with a point"),
        ("timeout: 0.5 s", "timeout: 0.5s", "0.5s", "write '0.5 s', with a blank"),
        ("timeout: 0.5 s", "timeout: 500ms", "500ms", "write '500 ms', with a blank"),
        ("timeout: 0.5 s", "timeout: 0.5", "0.5", "a duration has a unit: ms, s, min, h"),
        ("type: none", "type: std_msgs.msg.Empty", "std_msgs.msg.Empty", "write 'std_msgs/Empty'"),
        ("type: none", "type: std_msgs::Empty", "std_msgs::Empty", "write 'std_msgs/Empty'"),
        ("goto moving", "go to moving", "go to", "write 'goto'"),
        ("do front := value", "do front = min(r for r in value.a[-1..1] if r < 9)", "=",
         "write ':=' to assign"),
        ("do front := value", "do front += min(r for r in value.a)", "+",
         "write 'front := front + …'"),
        ("value }", "value.a[-1:1] }", ":", "write '..'"),
        ("on response from scan do front := value", "on scan do front := min(r for r in value.a)",
         "scan", "write 'response from scan'"),
        ("initial marked state on", "start state on", "start", "write 'initial'"),
        ("marked state on", "final state on", "final", "write 'marked'"),
        ("goto moving", "goto moving,\n", ",", "no separator stands between declarations"),
        ("service grab", "client grab", "client", "write 'service'"),
        ("service grab", "action_client grab", "action_client", "write 'action'"),
        ("component Laser", "sensor Laser", "sensor", "write 'component'"),
        ("robot Rover", "node Rover", "node", "write 'robot'"),
        ("robot Rover", 'import "base.rscd" robot Rover', "import",
         "a library is named where it is used: 'component NAME from LIBRARY import COMPONENT'"),
        ("provide move", "publish move", "publish", "write 'provide'"),
        ("requirement move needs", "move needs", "move", "write 'requirement move'"),
        ("requirement move needs", "if Laser.front < 0.3 then move disables", "if",
         "write 'requirement COMMAND needs CONDITION'"),
        ("requirement move needs", "never move and", "never",
         "write 'requirement never CONDITION'"),
        ("provide move with 0.2", "provide move with { linear.x: 0.2 }", ".",
         "write 'linear: { x: … }'"),
        ("provide move with 0.2", "provide move with { x = 0.2 }", "=", "write ':'"),
        ("requirement move needs", "-- slow\n    requirement move needs", "-",
         "a comment begins with '//'"),
    ],
)  # fmt: skip
def test_mistakes_of_beginners(right: str, wrong: str, marked: str, hint: str) -> None:
    """Each is one error, at its place, with its remedy; nothing that follows from it is told."""
    assert not read(GOOD)[1]
    assert right in GOOD
    text = GOOD.replace(right, wrong, 1)
    _, found = read(text)
    told = [(one.span.text, getattr(one.hint, "text", one.hint)) for one in found]
    assert told == [(marked, hint)]
    assert found[0].span.start == text.index(wrong) + wrong.index(marked)
