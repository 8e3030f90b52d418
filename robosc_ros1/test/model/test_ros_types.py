"""Types of ROS itself in a model: ``sensor_msgs/LaserScan`` and the like, checked field by field."""

from __future__ import annotations

from pathlib import Path
from types import SimpleNamespace

import pytest
from model_text import behaviour_of, faults, resolve
from test_ros_definitions import around, package

from robosc.emit.controller.python import Attributes
from robosc.expr.evaluation import evaluate
from robosc.expr.tree import Binary, Literal
from robosc.expr.types import (
    ArrayType,
    DoubleType,
    EnumType,
    IntegerType,
    NoneType,
    ObjectType,
    StringType,
)
from robosc.language.functions import HELPERS
from robosc.model.entities import Binding, DataArray, DataObject
from robosc.model.resolve import load
from robosc.model.ros.definitions import MessageDefinitions
from robosc.model.ros.object_types import DURATIONS
from robosc.source import Source
from robosc.syntax.formatting.format import format_text

ROS2 = """
<package format='3'>
    <name>{}</name> <version>1.0.0</version> <description>messages</description>
    <maintainer email="a@example.org">a</maintainer> <license>MIT</license>
    <export><build_type>ament_cmake</build_type></export>
</package>
"""

FILES = {
    "msg__Point": "float64 x\nfloat64 y\n",
    "msg__Scan": "int8 NEAR=1\nfloat32[] ranges\nPoint[2] ends\nstring frame\n",
    "msg__Empty": "",
    "msg__Mode": "uint8 NORMAL=1\nuint8 STOP=2\nstring NAME=soft\nfloat32 LIMIT=0.5\nuint8 mode\n",
    "srv__Arm": "bool value\n---\nbool success\nuint8 result\n",
    "msg__Way": "Point[] points\nduration pause\nfloat64[2] limits\nuint8[] colour\n",
    "srv__Reset": "---\n",
    "action__Go": "Point goal\n---\nuint16 error_code\n---\nfloat32 left\n",
}


@pytest.fixture(params=["ros1", "ros2"])
def p(request: pytest.FixtureRequest, tmp_path: Path) -> MessageDefinitions:
    """The package p, of both versions of ROS."""
    folder = package(tmp_path, "p", **FILES)
    if request.param == "ros2":
        (folder / "package.xml").write_text(ROS2.format("p"))
        way = (folder / "msg" / "Way.msg").read_text()
        durations = way.replace("duration", "builtin_interfaces/Duration")
        (folder / "msg" / "Way.msg").write_text(durations)
        times = package(tmp_path, "builtin_interfaces", msg__Duration="int32 sec\nuint32 nanosec\n")
        (times / "package.xml").write_text(ROS2.format("builtin_interfaces"))
    return around(tmp_path / "m.rscd")


INTEGER = IntegerType()
POINT = ObjectType("p/Point", "", (("x", DoubleType()), ("y", DoubleType())))


def test_a_message_brings_its_fields(p: MessageDefinitions) -> None:
    robot = resolve("component C { outgoing message scan with type: p/Scan }", p)
    scan = robot.communications["C.scan"]
    assert scan.binding == Binding("p", "Scan", True)
    assert isinstance(scan.response, ObjectType) and scan.response.name == "p/Scan"
    assert scan.response.properties == (
        ("ranges", ArrayType(DoubleType())),
        ("ends", ArrayType(POINT)),
        ("frame", StringType()),
    )


@pytest.mark.parametrize("spelling", ["p/Go", "p/GoAction", "p/action/Go"])
def test_an_action_brings_its_three_parts(p: MessageDefinitions, spelling: str) -> None:
    robot = resolve(f"component C {{ action go with type: {spelling} }}", p)
    go = robot.communications["C.go"]
    assert go.binding == Binding("p", "Go", True)
    parts = (go.request, go.response, go.feedback)
    assert [dict(part.properties) for part in parts if isinstance(part, ObjectType)] == [
        {"goal": POINT},
        {"error_code": IntegerType()},
        {"left": DoubleType()},
    ]


def test_a_part_without_fields_carries_nothing(p: MessageDefinitions) -> None:
    text = "component C { service reset with type: p/Reset  outgoing message e with type: p/Empty }"
    robot = resolve(text, p)
    reset = robot.communications["C.reset"]
    assert (reset.request, reset.response) == (NoneType(), NoneType())
    assert robot.communications["C.e"].response == NoneType()
    assert robot.communications["C.e"].binding == Binding("p", "Empty", True)


def test_fields_are_read_and_sent(p: MessageDefinitions) -> None:
    robot = resolve(
        """
        component C {
            outgoing message scan with identifier: "/scan", type: p/msg/Scan
            service arm with type: p/Arm
            action go with type: p/Go
            behaviour {
                variable near: boolean
                variable x: double
                initial marked state on {
                    on response from arm do near := value.success
                    on response from scan do x := value.ends[1].x
                }
            }
        }
        requirement arm needs C.near
        provide arm with { ^value: true }
        provide go with { goal: { x: C.x } }
        """,
        p,
    )
    (arm, go) = (provide.data for provide in robot.provides)
    assert isinstance(arm, DataObject) and isinstance(go, DataObject)


def test_an_enum_converts_a_message_and_needs_no_links(p: MessageDefinitions) -> None:
    robot = resolve(
        """
        component C { outgoing message scan with type: Way }
        datatype enum Way from p/Scan to { value.ranges[0] < 1 -> blocked default -> clear }
        """,
        p,
    )
    scan = robot.communications["C.scan"]
    assert scan.binding == Binding("p", "Scan", True) and isinstance(scan.response, EnumType)


@pytest.mark.parametrize(
    ("text", "found"),
    [
        ("outgoing message m with type: q/Scan", [("ros-type-unknown", "q")]),
        ("outgoing message m with type: p/Scam", [("interface-not-found", "Scam")]),
        ("outgoing message m with type: p/srv/Arm", [("interface-not-found", "srv")]),
        ("service s with type: p/Scan", [("interface-not-found", "Scan")]),
        ("service s with type: q/Arm", [("ros-type-unknown", "q")]),
        (
            "outgoing message m with type: p/Scan"
            " behaviour { initial marked state s { transition if value.range } }",
            [("value-not-allowed", "value")],
        ),
        (
            "outgoing message m with type: p/Scan behaviour { initial marked state s"
            " { on response from m if value.range goto s } }",
            [("unknown-member", "range")],
        ),
        (
            "outgoing message m with type: p/Scan behaviour { variable d: boolean initial marked"
            " state s { on response from m do d := value.ends[2].x < 1 } }",
            [("field-index", "value.ends[2].x")],
        ),
        (
            "outgoing message m with type: p/Point links scan",
            [("field-kind", "p/Point")],
        ),
    ],
)
def test_what_does_not_fit_is_an_error(
    p: MessageDefinitions, text: str, found: list[tuple[str, str]]
) -> None:
    told = faults(f"component C {{ {text} }} interface scan use Scan from p", p)
    ignored = ("unused-interface", "unused-variable", "not-finite")
    assert [fault for fault in told if fault[0] not in ignored] == found


def test_what_is_sent_must_fit_its_field(p: MessageDefinitions) -> None:
    text = "component C { service arm with type: p/Arm } provide arm with { %s }"
    assert ("unknown-property", "worth") in faults(text % "worth: true", p)
    assert ("type-mismatch", "3") in faults(text % "^value: 3", p)


WAY = "component C { incoming message way with type: p/Way } provide way with { %s }"


def test_arrays_and_durations_are_sent(p: MessageDefinitions) -> None:
    text = WAY % "points: [{ x: 1.0 }, { y: 2 }], limits: [-1, 1.5], colour: [255], pause: 1.5 s"
    (provide,) = resolve(text, p).provides
    assert isinstance(provide.data, DataObject)
    data = dict(provide.data.fields)
    points, pause = data["points"], data["pause"]
    assert isinstance(points, DataArray) and isinstance(pause, DataObject)
    assert points.elements[1] == DataObject((("y", Literal(2.0, DoubleType())),))
    seconds, nanoseconds = (value for _, value in pause.fields)
    assert (seconds, nanoseconds) == (Literal(1, INTEGER), Literal(500_000_000, INTEGER))


@pytest.mark.parametrize(
    ("written", "parts"),
    [
        ("-0.5 s", (-1, 500_000_000)),
        ("-2 s", (-2, 0)),
        ("0 s", (0, 0)),
        ("-1 ms", (-1, 999_000_000)),
    ],
)
@pytest.mark.parametrize("named", [False, True])
def test_sent_durations_may_be_negative(
    p: MessageDefinitions, written: str, parts: tuple[int, int], named: bool
) -> None:
    text = WAY % ("pause: " + ("back" if named else written))
    robot = resolve(f"constant back: duration = {written} {text}" if named else text, p)
    (data,) = (dict(provide.data.fields)["pause"] for provide in robot.provides)
    assert tuple(evaluate(value, lambda leaf: None) for _, value in data.fields) == parts


@pytest.mark.parametrize(
    ("data", "fault"),
    [
        ("limits: [1.0]", ("field-length", "[1.0]")),
        ("limits: [1.0, true]", ("type-mismatch", "true")),
        ("colour: [1, 256]", ("field-range", "256")),
        ("points: [1.0]", ("type-mismatch", "1.0")),
        ("points: [{ u: 1.0 }]", ("unknown-property", "u")),
        ("points: { x: 1.0 }", ("type-mismatch", "{")),
        ("points: 1.0", ("type-mismatch", "1.0")),
        ("pause: [1]", ("type-mismatch", "[")),
        ("pause: 3", ("type-mismatch", "3")),
    ],
)
def test_arrays_must_fit_their_field(
    p: MessageDefinitions, data: str, fault: tuple[str, str]
) -> None:
    assert fault in faults(WAY % data, p)


def test_a_property_can_be_a_message(p: MessageDefinitions) -> None:
    text = """
    component C { action go with request: Goal, response: none, feedback: none links go }
    datatype object Goal { goal: p/%s }
    interface go use Go from p
    """
    resolve(text % "Point", p)
    assert ("field-kind", "p/Scan") in faults(text % "Scan", p)


@pytest.mark.parametrize("constant", ["safety.STOP", "p/Mode.STOP", "p/msg/Mode.STOP"])
def test_constants_of_a_definition(p: MessageDefinitions, constant: str) -> None:
    text = f"""
    component C {{
        outgoing message m with type: Stop
        behaviour {{
            variable stop: Stop
            variable speed: double
            initial marked state s {{ on response from m do stop := value, speed := p/Mode.LIMIT }}
        }}
    }}
    requirement always C.stop = go
    datatype enum Stop from p/Mode to {{ value.mode = {constant} -> halt default -> go }}
    interface safety use Mode from p
    """
    (rule,) = next(
        v.type.rules
        for v in behaviour_of(resolve(text, p), "C").variables
        if isinstance(v.type, EnumType)
    )
    assert isinstance(rule.condition, Binary)
    assert rule.condition.right == Literal(2, IntegerType())


def test_a_constant_that_is_not_there_has_a_nearest_one(p: MessageDefinitions) -> None:
    text = """
    component C { outgoing message m with type: Stop }
    datatype enum Stop from p/Mode to { value.mode = p/Mode.STOPP -> halt default -> go }
    """
    assert ("unknown-member", "STOPP") in faults(text, p)
    assert ("interface-not-found", "Mood") in faults(text.replace("Mode.STOPP", "Mood.STOP"), p)


def test_a_division_by_a_variable_is_no_constant(p: MessageDefinitions) -> None:
    text = """
    component C {
        incoming message m with type: double
        behaviour { variable p: double = 1.0 initial marked state s { on request to m } }
    }
    component D { behaviour { variable x: double = 2.0 initial marked state s {} } }
    provide m with C.p / D.x
    """
    resolve(text, p)


def test_formatting_keeps_types_of_ros() -> None:
    text = (
        "robot R { component C { service a with type: p / srv/Arm action g with identifier:"
        " '/g' , type: p/Go outgoing message m with type: array(p/Point) } }"
    )
    formatted = format_text(Source("m.rscd", text))
    for part in ("a with type: p/srv/Arm", "identifier: '/g', type: p/Go", "array(p/Point)"):
        assert part in formatted


def test_a_missing_package_is_told_once_with_what_to_install() -> None:
    text = "robot R { component C { outgoing message m with type: nav_msgs/Odometry } }"
    robot, diagnostics = load(Source("m.rscd", text), definitions=MessageDefinitions())
    assert robot is None
    (fault,) = diagnostics
    assert fault.code == "ros-type-unknown" and "ros-nav-msgs" in (fault.hint or "")


@pytest.mark.parametrize(
    ("default", "parts"),
    [
        ("1.5 s", (1, 500_000_000)),
        ("0.1 s", (0, 100_000_000)),
        ("1 h", (3600, 0)),
        ("999999999.5 ms", (999_999, 999_500_000)),
        ("2.9999999999 s", (3, 0)),
    ],
)
@pytest.mark.parametrize("word", ["constant", "parameter"])
def test_durations_are_sent_by_name(
    p: MessageDefinitions, word: str, default: str, parts: tuple[int, int]
) -> None:
    text = f"{word} long: duration = {default} {WAY % 'pause: long'}"
    robot = resolve(text, p)
    (data,) = (dict(provide.data.fields)["pause"] for provide in robot.provides)
    assert isinstance(data, DataObject)
    assert tuple(name for name, _ in data.fields) in DURATIONS.values()
    assert tuple(evaluate(value, lambda leaf: None) for _, value in data.fields) == parts
    attributes = Attributes(robot, {}, {}, {}, {}, parameters={"long": "long"})
    controller = SimpleNamespace(long=robot.parameters[0].default if robot.parameters else None)
    for (_, value), part in zip(data.fields, parts, strict=True):
        assert eval(attributes.text(value), {**HELPERS, "self": controller}) == part
