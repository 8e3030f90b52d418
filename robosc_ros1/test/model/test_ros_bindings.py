"""Which ROS message carries a communication, and whether the types of the model fit it."""

from __future__ import annotations

from pathlib import Path

import pytest
from model_text import faults, resolve
from test_ros_definitions import around, package

from robosc.errors import Severity
from robosc.model.entities import Binding, Robot
from robosc.model.resolve import load
from robosc.model.ros.definitions import (
    MessageDefinitions,
)
from robosc.source import Source

EXAMPLES = Path(__file__).resolve().parents[3] / "examples"


@pytest.fixture
def p(tmp_path: Path) -> MessageDefinitions:
    package(
        tmp_path,
        "p",
        msg__Number="Header header\nint32 value\n",
        msg__Small="int8 i\nuint8 u\nfloat32 f\nstring s\nbool b\nchar c\nbyte y\n",
        msg__Scan="float32[] ranges\nfloat64[2] two\nSmall[] small\ntime stamp\n",
        msg__Speed="int32 speed\n",
        msg__Lost="no_such_msgs/Thing thing\n",
        srv__Add="int16 a\n---\nfloat64 sum\n",
        action__Go="bool fast\n---\nstring how\n---\nfloat32 done\n",
    )
    return around(tmp_path / "m.rscd")


def binding(robot: Robot, name: str) -> Binding:
    return robot.communications[f"P.{name}"].binding


def test_basic_types_have_their_standard_messages() -> None:
    robot = resolve(
        """
        component P {
            incoming message n with type: none
            incoming message b with type: boolean
            outgoing message i with type: integer(0..9)
            outgoing message d with type: E
            incoming message s with type: string
        }
        datatype enum E from double to { default -> a }
        """
    )
    assert binding(robot, "n") == Binding("std_msgs", "Empty", True)
    assert binding(robot, "b") == Binding("std_msgs", "Bool", True, request_field="data")
    assert binding(robot, "i") == Binding("std_msgs", "Int16", True, response_field="data")
    assert binding(robot, "d") == Binding("std_msgs", "Float32", True, response_field="data")
    assert binding(robot, "s") == Binding("std_msgs", "String", True, request_field="data")


LINKED = """
component P {
    outgoing message n with type: integer links number
    service add with request: integer(0..100), response: double links add
    action go with request: boolean, response: E, feedback: none links go
}
datatype enum E from string to { value = "well" -> good default -> bad }
interface number use Number from p
interface add use Add from p
interface go use GoAction from p
"""


def test_basic_types_travel_through_the_only_field_of_a_linked_interface(
    p: MessageDefinitions,
) -> None:
    robot = resolve(LINKED, p)
    assert binding(robot, "n") == Binding("p", "Number", True, response_field="value")
    assert binding(robot, "add") == Binding("p", "Add", True, "a", "sum")
    assert binding(robot, "go") == Binding("p", "Go", True, "fast", "how", None)


def test_a_package_that_is_not_found_is_told_once_and_the_robot_is_there_all_the_same() -> None:
    source = Source("m.rscd", f"robot Test {{ {LINKED} }}")
    robot, diagnostics = load(source, definitions=MessageDefinitions())
    assert robot is not None
    assert [d.code for d in diagnostics if d.code == "package-not-found"] == ["package-not-found"]
    assert binding(robot, "go") == Binding("p", "Go", False)
    robot, diagnostics = load(source, definitions=MessageDefinitions(), strict=True)
    assert robot is None
    assert any(d.severity is Severity.ERROR for d in diagnostics)


@pytest.mark.parametrize(
    ("type_", "field", "sent", "received"),
    [
        ("integer", "i", True, True),
        ("integer(-128..127)", "i", True, True),
        ("integer(-129..127)", "i", False, True),
        ("integer(0..255)", "u", True, True),
        ("integer(-1..255)", "u", False, True),
        ("integer(0..255)", "c", True, True),
        ("integer(-128..127)", "y", True, True),
        ("double", "i", False, True),
        ("integer", "f", True, False),
        ("double", "f", True, True),
        ("boolean", "b", True, True),
        ("boolean", "u", False, False),
        ("integer", "b", False, False),
        ("string", "s", True, True),
        ("string", "i", False, False),
        ("double", "s", False, False),
    ],
)
def test_what_fits_depends_on_the_direction(
    p: MessageDefinitions, type_: str, field: str, sent: bool, received: bool
) -> None:
    text = f"""
    component P {{ %s message m with type: O links small }}
    datatype object O {{ {field}: {type_} }}
    interface small use Small from p
    """
    assert (faults(text % "incoming", p) == []) is sent
    assert (faults(text % "outgoing", p) == []) is received


def test_arrays_times_and_nested_messages(p: MessageDefinitions) -> None:
    text = """
    component P { outgoing message m with type: Scan links scan }
    datatype object Scan {
        ranges: array(double)
        two: array(double)
        small: array(Small)
        stamp: Time
    }
    datatype object Small { i: integer b: Flag }
    datatype object Time { secs: integer nsecs: integer }
    datatype enum Flag from boolean to { value -> on default -> off }
    interface scan use Scan from p
    """
    assert [f for f in faults(text, p) if f[0] != "unused-enum-value"] == []
    wrong = text.replace("i: integer", "ii: integer").replace("secs: integer n", "secs: string n")
    assert [f for f in faults(wrong, p) if f[0] != "unused-enum-value"] == [
        ("unread-field", "ii"),
        ("field-kind", "string"),
    ]


def test_a_nested_message_of_a_package_that_is_not_there_is_a_warning(
    p: MessageDefinitions,
) -> None:
    text = """
    component P { outgoing message m with type: Lost links lost }
    datatype object Lost { thing: Thing }
    datatype object Thing { x: double }
    interface lost use Lost from p
    """
    assert faults(text, p) == [("package-not-found", "Thing")]


def test_provided_values_must_fit_the_field(p: MessageDefinitions) -> None:
    text = """
    component P {
        incoming message m with type: O links small
        service add with request: integer, response: none links add
        behaviour { variable wide: integer(0..200) initial marked state s {} }
    }
    datatype object O { i: integer u: integer f: double }
    interface small use Small from p
    interface add use Add from p
    provide m with { i: %s, u: 255, f: 3 }
    provide add with %s
    stop with m
    """
    assert faults(text % ("-128", "32767"), p) == [("unused-variable", "wide")]
    assert faults(text % ("-129", "32768"), p) == [
        ("field-range", "-129"),
        ("field-range", "32768"),
    ]
    assert faults(text % ("P.wide", "1"), p) == [("field-range", "P.wide")]


def test_one_object_is_checked_against_each_interface_once(p: MessageDefinitions) -> None:
    text = """
    component P {
        incoming message m with identifier: "/m", type: O links small
        incoming message n with identifier: "/n", type: O links small
    }
    datatype object O { missing: integer }
    interface small use Small from p
    """
    assert faults(text, p) == [("unread-field", "missing")]


@pytest.mark.parametrize(
    "use",
    [
        "} provide sent with { missing: 3 ",
        "behaviour { variable v: integer initial marked state s"
        " { on response from m do v := value.missing } }",
    ],
)
def test_a_property_without_field_is_an_error_if_it_is_read_or_sent(
    p: MessageDefinitions, use: str
) -> None:
    text = f"""
    component P {{
        outgoing message m with identifier: "/m", type: O links small
        incoming message sent with identifier: "/n", type: O links small
        {use}
    }}
    datatype object O {{ missing: integer }}
    interface small use Small from p
    """
    assert ("unknown-field", "missing") in faults(text, p)


@pytest.mark.parametrize(
    "use",
    [
        "} provide sent with { speed: 3 } provide other with { speed: 4 ",
        "behaviour { variable v: integer initial marked state s"
        " { on response from m do v := value.speed } }",
    ],
)
def test_a_misspelt_property_is_one_fault_where_it_is_declared(
    p: MessageDefinitions, use: str
) -> None:
    """The field has the name that is used: two fixes that undo one another are one too many."""
    text = f"""
    component P {{
        outgoing message m with identifier: "/m", type: O links speed
        incoming message sent with identifier: "/n", type: O links speed
        incoming message other with identifier: "/o", type: O links speed
        {use}
    }}
    datatype object O {{ sped: integer }}
    interface speed use Speed from p
    """
    assert faults(text, p) == [("unknown-field", "sped")]
    mended = faults(text.replace("sped", "speed"), p)
    assert {code for code, _ in mended} <= {"unused-variable", "no-stop"}


def test_a_property_without_field_is_no_error_where_another_message_reads_it(
    p: MessageDefinitions,
) -> None:
    """One datatype stands for two messages; of the one that lacks the field nothing is read."""
    text = """
    component P {
        outgoing message m with type: O links small
        outgoing message n with type: O
        behaviour { variable v: integer initial marked state s {
            on response from m do v := 1 on response from %s do v := value.data } }
    }
    datatype object O { data: integer }
    interface small use Small from p
    interface other use Int16 from std_msgs
    """
    linked = text.replace("n with type: O", "n with type: O links other")
    assert ("unread-field", "data") in faults(linked % "n", p)
    assert ("unknown-field", "data") in faults(linked.replace("from m do v := 1", "") % "m", p)


def test_the_line_follower_is_sound_without_any_environment(
    monkeypatch: pytest.MonkeyPatch, ros: None
) -> None:
    monkeypatch.delenv("ROS_PACKAGE_PATH", raising=False)
    monkeypatch.delenv("CMAKE_PREFIX_PATH", raising=False)
    monkeypatch.chdir(EXAMPLES.parent)
    robot, diagnostics = load("examples/line_follower/line_follower.rscd")
    assert robot is not None
    assert diagnostics == ()
    assert all(c.binding.found for c in robot.communications.values())
    assert robot.communications["ObstacleGrabber.grab"].binding.type == "Grabber"


def test_a_misspelt_package_has_a_nearest_one(tmp_path: Path) -> None:
    package(tmp_path, "gripper_msgs", msg__M="int8 a\n")
    text = """robot R {
        interface link use M from griper_msgs
        component C { outgoing message m with type: integer links link }
    }"""
    source = Source(str(tmp_path / "m.rscd"), text)
    _, diagnostics = load(source, definitions=around(tmp_path / "m.rscd"))
    (found,) = (d for d in diagnostics if d.code == "package-not-found")
    assert found.hint is not None and found.hint.startswith("did you mean 'gripper_msgs'?")


@pytest.mark.parametrize(
    ("linked", "ok"), [("Number from p", True), ("Speed from p", False), ("Far from away", True)]
)
def test_an_age_needs_a_header(p: MessageDefinitions, linked: str, ok: bool) -> None:
    found = faults(
        f"""
        component P {{
            outgoing message m with max_age: 2 s, type: O links l
        }}
        datatype object O {{}}
        interface l use {linked}
        """,
        p,
    )
    assert (("unknown-field", "2 s") not in found) is ok


def test_messages_that_cannot_be_heavy_are_known_by_their_fields(tmp_path: Path) -> None:
    package(
        tmp_path,
        "p",
        msg__Fixed="Header header\nfloat64[36] covariance\ntime at\n",
        msg__Large="float64[10000] numbers\n",
        msg__Many="Fixed[1000] all\n",
        msg__Text="string text\n",
        msg__Around="Text text\n",
        msg__Scan="float32[] ranges\n",
    )
    names = ("Fixed", "Large", "Many", "Text", "Around", "Scan")
    robot = resolve(
        "component P {"
        + "".join(f"outgoing message m{n} with type: none links i{n}\n" for n in names)
        + "}\n"
        + "".join(f"interface i{n} use {n} from p\n" for n in names),
        around(tmp_path / "m.rscd"),
    )
    assert [n for n in names if binding(robot, f"m{n}").light] == ["Fixed"]
