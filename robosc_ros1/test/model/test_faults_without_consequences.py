"""One mistake makes one error: what follows from it is silent, what does not is told."""

from __future__ import annotations

from pathlib import Path

import pytest
from model_text import faults

from robosc.model.resolve import load
from robosc.model.ros.definitions import MessageDefinitions
from robosc.source import Source

MOTOR = """
component Motor {
    incoming message move with type: none
    behaviour {
        initial marked state idle { on request to move goto busy }
        marked state busy { on request to halt goto idle }
    }
}
"""


def test_what_a_second_component_of_one_name_declares_is_not_unknown() -> None:
    second = """
    component Motor {
        incoming message halt with type: none
        behaviour { initial marked state off {} }
    }
    requirement halt needs Motor.off
    """
    assert faults(MOTOR + second) == [("duplicate-name", "Motor")]


def test_the_content_of_a_second_component_of_one_name_is_checked() -> None:
    second = """
    component Motor {
        incoming message halt with type: dooble
        behaviour { initial marked state off { on request to move goto of } }
    }
    """
    assert faults(MOTOR + second) == [
        ("duplicate-name", "Motor"), ("unknown-type", "dooble"), ("unknown-state", "of"),
    ]  # fmt: skip


def test_a_second_datatype_of_one_name_is_checked_and_its_values_are_not_unknown() -> None:
    text = """
    component Sensor {
        outgoing message range with type: Range
        behaviour {
            variable range: Range
            initial marked state on_ { on response from range do range := value }
        }
    }
    component Motor { incoming message move with type: none }
    requirement move needs Sensor.range = near
    datatype enum Range from double to { value > 1 -> far default -> here }
    datatype enum Range from integer to { value > "1" -> near default -> here }
    """
    assert faults(text) == [("duplicate-name", "Range"), ("type-mismatch", '"1"')]


def test_a_second_behaviour_is_checked() -> None:
    text = """
    component Motor {
        incoming message move with type: none
        behaviour { initial marked state idle {} }
        behaviour { variable speed: integer(0..3) initial marked state off {
            on request to move do sped := 1 } }
    }
    requirement move needs Motor.speed = 2
    """
    assert faults(text) == [("several-behaviours", "behaviour"), ("unknown-name", "sped")]


def test_a_faulty_requirement_hides_no_unknown_name_elsewhere() -> None:
    text = (
        MOTOR.replace("halt", "move")
        + """
    requirement Motor.idle disable move
    requirement move needs motor.idle
    """
    )
    assert faults(text) == [("syntax", "disable"), ("unknown-name", "motor")]


def test_a_faulty_declaration_inside_a_statement_hides_the_names_that_it_may_declare() -> None:
    text = """
    component Motor { incoming message move with type: none }
    requirement move needs
    component Arm { incoming message lift with typ: none }
    requirement lift needs Arm.up
    """
    assert [code for code, _ in faults(text)] == ["syntax", "syntax"]


def test_a_component_without_behaviour_has_no_states() -> None:
    text = """
    component Motor { incoming message move with type: none }
    requirement move needs Motor.idle
    """
    assert faults(text) == [("unknown-member", "idle")]


WHEELS = """library Wheels {
    constant gain: double = 2.0
    condition true_ = true
    function twice(x: double): double = x * gain
    datatype enum Level from double to { value > gain -> high default -> low }
    component Wheel { FAULT incoming message turn with type: none }
}
"""
OF_WHEELS = """
component Base {
    outgoing message speed with type: double
    incoming message go with type: double
    behaviour {
        variable level: Wheels.Level
        variable v: double = Wheels.gain
        initial marked state on_ {
            on response from speed do level := Wheels.Level(value), v := Wheels.twice(value)
        }
    }
}
requirement go needs Base.level = Wheels.Level.high and Base.v > Wheels.gain and Wheels.true_
provide go with Wheels.twice(Base.v)
"""


@pytest.mark.parametrize("imported", ["", "component Left from Wheels import Wheel\n"])
@pytest.mark.parametrize("fault", ["missing", "incoming message turn with type: none", ")"])
def test_what_names_a_faulty_library_is_right(fault: str, imported: str, tmp_path: Path) -> None:
    (tmp_path / "Wheels.rscd").write_text(WHEELS.replace("FAULT", fault))
    source = Source(str(tmp_path / "robot.rscd"), "robot R {" + imported + OF_WHEELS + "}")
    robot, diagnostics = load(source)
    assert robot is None
    assert {Path(d.span.source.path).name for d in diagnostics} == {"Wheels.rscd"}


def test_calls_of_a_function_that_cannot_be_read_are_right() -> None:
    text = """function f(x: double): double = x +
        requirement move needs f(0) > 0
        component Motor { incoming message move with type: double }
        provide move with f(1)
    """
    assert [code for code, _ in faults(text)] == ["syntax"]


def test_names_of_a_library_are_looked_up_whatever_else_is_wrong(tmp_path: Path) -> None:
    (tmp_path / "Wheels.rscd").write_text(
        "library Wheels { component Wheel { incoming message turn with type: none"
        " behaviour { initial marked state ok {} } } }"
    )
    model = """robot Cart {
        component Left from Wheels import Wheel with prefix "/left"
        component Right from Wheels import Wheel with prefix: "/right" {
            behaviour { initial marked state idle {} }
        }
        requirement Right.turn needs Right.okk
    }"""
    no_prefix = "expected 'prefix:' or the name of a constant or parameter after 'with'"
    _, found = load(Source(str(tmp_path / "model.rscd"), model), definitions=MessageDefinitions())
    assert [(d.code, d.span.text, d.message) for d in found] == [
        ("syntax", "prefix", no_prefix),
        ("syntax", "{", "an imported component cannot be extended"),
        ("unknown-member", "okk", "Right has no variable or state 'okk'"),
    ]


@pytest.mark.parametrize(
    ("written", "meant"),
    [("float", "double"), ("float32", "double"), ("Int16", "integer"), ("bool", "boolean")],
)
def test_types_of_ros_and_other_languages_are_understood(written: str, meant: str) -> None:
    _, found = load(
        Source(
            "m.rscd", f"robot R {{ component C {{ outgoing message m with type: {written} }} }}"
        ),
        definitions=MessageDefinitions(),
    )
    assert [(d.code, d.hint) for d in found] == [("unknown-type", f"write '{meant}'")]


def test_a_missing_with_is_named() -> None:
    _, found = load(
        Source("m.rscd", "robot R { component C { outgoing message m type: double } }"),
        definitions=MessageDefinitions(),
    )
    assert [(d.span.text, d.hint) for d in found] == [("type", "'with' is missing before it")]


@pytest.mark.parametrize(
    ("condition", "marked"),
    [("Motor.idle and", "and"), ("Motor.speed >", ">"), ("(Motor.idle", "idle"), ("!", "!")],
)
def test_a_condition_that_breaks_off_is_marked_where_it_ends(condition: str, marked: str) -> None:
    text = MOTOR.replace("halt", "move") + f"requirement move needs {condition}\n"
    assert faults(text + "requirement move needs Motor.idle\n") == [("syntax", marked)]


def test_a_value_that_stands_as_a_rule_is_compared_in_the_hint() -> None:
    text = "robot R { datatype enum E from integer to { 3 -> three default -> other } }"
    _, found = load(Source("m.rscd", text), definitions=MessageDefinitions())
    assert [d.hint for d in found if d.code == "type-mismatch"] == ["write: value = 3"]


def test_several_communications_without_braces() -> None:
    text = "robot R { requirement go, halt needs true }"
    _, found = load(Source("m.rscd", text), definitions=MessageDefinitions())
    assert [(d.span.text, d.hint) for d in found] == [(",", "write several in braces: { …, … }")]


def test_an_event_that_does_not_exist_may_bring_any_value() -> None:
    sensor = """
    component Sensor {
        outgoing message seen with type: boolean
        behaviour {
            variable last: boolean
            initial marked state on { on request from seen if value do last := value }
        }
    }
    requirement always Sensor.last or !Sensor.last
    """
    assert ("event-not-available", "request") in faults(sensor)
    assert "value-not-allowed" not in dict(faults(sensor))


def test_a_name_that_is_a_state_and_a_boolean_variable_cannot_be_read() -> None:
    lamp = """
    component Lamp {
        incoming message light with type: none
        behaviour {
            variable on: boolean
            initial marked state on { transition if on goto off }
            marked state off { on request to light }
        }
    }
    requirement light needs Lamp.on
    """
    assert faults(lamp) == [("ambiguous-name", "on"), ("ambiguous-name", "Lamp.on")]
    unread = lamp.replace("if on ", "").replace("needs Lamp.on", "needs Lamp.off")
    assert faults(unread) == [("unused-variable", "on")]


def test_booleans_of_other_languages() -> None:
    text = "robot R { requirement always True => B.c }"
    _, diagnostics = load(Source("model.rscd", text))
    assert diagnostics[0].hint == "did you mean 'true'?"


def test_a_datatype_with_the_name_of_one_of_another_kind_is_checked() -> None:
    object_ = "datatype object Range { x: dooble }"
    enum = 'datatype enum Range from integer to { value > "1" -> near default -> far }'
    assert faults(object_ + enum) == [
        ("unknown-type", "dooble"), ("duplicate-name", "Range"), ("type-mismatch", '"1"'),
    ]  # fmt: skip
    assert ("unknown-type", "dooble") in faults(enum + object_)


def test_no_more_errors_are_told_than_anybody_reads() -> None:
    found = faults(
        MOTOR.replace("halt", "move") + "requirement move needs " + " or ".join("a" * 1500)
    )
    assert len(found) == 1001
    assert {code for code, _ in found[:1000]} == {"unknown-name"}
    assert found[1000] == ("too-many-errors", "a")


@pytest.mark.parametrize(
    ("keyword", "text"),
    [
        ("state", "state { transition goto idle }"),
        ("variable", "variable : boolean"),
        ("variable", "variable 1st: boolean"),
    ],
)
def test_a_name_that_is_missing_in_a_behaviour_may_be_any(keyword: str, text: str) -> None:
    use = {
        "state": "on request to move goto busy",
        "variable": "on request to move if first do second := true goto idle",
    }
    model = f"""
    component Motor {{
        incoming message move with type: none
        behaviour {{
            initial marked state idle {{ {use[keyword]} }}
            {text}
        }}
    }}
    """
    assert [code for code, _ in faults(model)] == ["syntax"]


@pytest.mark.parametrize(
    ("text", "use"),
    [
        ("component { incoming message go with type: none }", "requirement go needs Motor.idle"),
        ("component A { incoming message with type: none }", "requirement go needs Motor.idle"),
        ("component A { service with request: none }", "requirement go needs Motor.idle"),
        ("component { behaviour {} }", "requirement move needs Other.idle"),
        ("datatype object { x: double }", "component A { outgoing message m with type: Point }"),
        ("datatype enum from double to {}", "component A { outgoing message m with type: Point }"),
        ("interface use A from b", "component A { outgoing message m with type: none links l }"),
    ],
)
def test_a_name_that_is_missing_may_be_any_of_its_kind(text: str, use: str) -> None:
    motor = """
    component Motor {
        incoming message move with type: none
        behaviour { initial marked state idle {} }
    }
    """
    assert [code for code, _ in faults(motor + text + use)] == ["syntax"]
    (told,) = faults(motor + use)
    assert told[0].startswith("unknown-"), "without the other fault it is told"


ARM = """
    interface lift use Lift from arm_msgs
    datatype object Height { low: double high: double }
    datatype enum Level from Height to { value.low > 1 -> up value.high < 0 -> down default -> between }
    component Arm {
        outgoing message seen with timeout: 1 s, type: Level links lift
        service raise with request: Height, response: none links lift
        behaviour {
            variable level: Level
            initial marked state resting { on request to raise goto moving }
            state moving {
                on response from raise if Arm.level = up goto resting
                on response from raise if Arm.level != up goto resting
                on error from raise goto resting
                on response from seen do level := value
                on timeout from seen goto resting
            }
        }
    }
    requirement raise needs Arm.resting and Arm.level = down
    provide raise with { low: 1, high: 2 } if Arm.level = up
    provide raise with { low: 0 } if Arm.level = down
"""


@pytest.mark.parametrize(
    ("before", "after"),
    [
        ("low: double", "low double"),
        ("high: double", ": double"),
        ("-> down", "->"),
        ("type: Level", "type:"),
        ("type: Level", "type: Level Level"),
        ("none links lift", "none lift"),
        ("Level links lift", "Level lift"),
        ("state moving", "state state moving"),
        ("from raise if", "from from raise if"),
        ("raise if Arm.level = up goto", "raise Arm.level = up goto"),
        ("request to raise", "request to to raise"),
        ("needs Arm.resting and", "needs Arm.resting Arm and"),
        (
            "requirement raise needs Arm.resting and Arm.level = down",
            "requirement raise needs Arm.",
        ),
        ("} if Arm.level = up", "} if if Arm.level = up"),
        ("with { low: 1", "with with { low: 1"),
    ],
)
def test_one_slip_is_one_error(before: str, after: str) -> None:
    assert [code for code, _ in faults(ARM)] == ["package-not-found"]
    told = [
        code for code, _ in faults(ARM.replace(before, after, 1)) if code != "package-not-found"
    ]
    assert len(told) == 1


def test_a_prefix_that_is_none_makes_no_topics(tmp_path: Path) -> None:
    (tmp_path / "Arms.rscd").write_text(
        "library Arms { component Arm { outgoing message angle with type: double } }"
    )
    robot = """robot Twin {
        component Left from Arms import Arm with prefix: "1st"
        component Right from Arms import Arm with prefix: "2nd"
        component Third from Arms import Arm
    }"""
    _, found = load(Source(str(tmp_path / "twin.rscd"), robot))
    assert [d.code for d in found] == ["ros-name", "ros-name"]


@pytest.mark.parametrize(
    "place",
    [
        "component Eye { outgoing message scan with timeout: {0}, type: none }",
        "component Eye { behaviour { initial marked state on { after {0} goto on } } }",
        "parameter pause: duration = {0}",
    ],
)
@pytest.mark.parametrize("duration", ["0 s", "0.0001 ms", "0.999 ms"])
def test_nothing_waits_for_less_than_a_millisecond(place: str, duration: str) -> None:
    assert ("out-of-range", duration) in faults(place.replace("{0}", duration))
    assert "out-of-range" not in {code for code, _ in faults(place.replace("{0}", "1 ms"))}


def test_a_message_with_a_faulty_timeout_is_fresh_or_silent() -> None:
    text = """
    component Eye { outgoing message scan with timeout: 0 s, type: none }
    component Motor { incoming message move with type: none }
    requirement move needs scan.fresh
    """
    assert faults(text) == [("out-of-range", "0 s")]


@pytest.mark.parametrize(
    ("line", "begun"),
    [
        ("outgoing message seen with timeout: 1 s, type: boolean", "outgoing"),
        ("outgoing message seen with timeout: 1 s, type: boolean", "outgoing message"),
        (
            "outgoing transform base with from: 'map', to: 'base', timeout: 1 s",
            "outgoing transform",
        ),
        ("incoming message move with type: none", "incoming"),
        ("service open with type: std_srvs/Trigger", "service"),
        ("condition free = Eye.near", "condition"),
        ("constant most: integer = 3", "constant"),
        ("parameter least: integer = 3", "parameter"),
        ("function doubled(x: integer): integer = 2 * x", "function"),
        ("marked state resting {}", "marked"),
    ],
)
def test_what_a_declaration_that_was_begun_would_name_is_not_unknown(line: str, begun: str) -> None:
    """As while it is typed in an editor: what uses it stands elsewhere, and is right."""
    text = """
    condition free = Eye.near
    constant most: integer = 3
    parameter least: integer = 3
    function doubled(x: integer): integer = 2 * x
    component Eye {
        outgoing message seen with timeout: 1 s, type: boolean
        outgoing transform base with from: 'map', to: 'base', timeout: 1 s
        service open with type: std_srvs/Trigger
        incoming message move with type: none
        behaviour {
            variable near: boolean
            variable count: integer
            on response from seen do near := value, count := doubled(count)
            initial marked state waiting { on request to move goto resting }
            marked state resting {}
        }
    }
    requirement { move, open } needs seen.fresh and base.fresh and open.idle and free
    requirement move needs Eye.count < most and Eye.count > least
    """.replace("'", '"')
    line = line.replace("'", '"')
    no_definitions = ("package-not-found", "ros-type-unknown")
    assert not [code for code, _ in faults(text) if code not in no_definitions]
    assert text.count(f"{line}\n") == 1
    found = faults(text.replace(f"{line}\n", f"{begun}\n"))
    assert [code for code, _ in found if code not in no_definitions] == ["syntax"]
