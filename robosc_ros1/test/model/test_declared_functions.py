"""A call of a model's function means its body with the arguments in it."""

from __future__ import annotations

from pathlib import Path

import pytest
from model.model_text import faults, resolve

from robosc.errors import render_all
from robosc.model.entities import Robot
from robosc.model.resolve import load
from robosc.model.ros.definitions import MessageDefinitions

ROBOT = """
constant low: double = 0.5
parameter gain: double = 2.0
datatype object Point { x: double y: double }
datatype object Scan { ranges: array(double) weights: array(double) at: Point }
interface scan use LaserScan from sensor_msgs
FUNCTIONS
component Laser {
    outgoing message beams with timeout: 1 s, type: Scan links scan
    incoming message drive with type: double
    behaviour {
        variable front: double
        variable clear: boolean
        initial marked state on { on response from beams do front := VALUE, clear := TEST }
    }
}
requirement drive needs beams.fresh and Laser.clear and NEEDS
provide drive with DATA
stop with drive
"""
FUNCTIONS = """
function half(x: double): double = x / 2
function quarter(x: double): double = half(half(x))
function scaled(x: double): double = x * gain + low
function nearest(r: array(double)): double = min(d for d in r if d > low) else 0.0
function left(s: Scan): double = s.ranges[0] + s.at.x
function at_x(p: Point, more: double): double = p.x + more
function above(n: integer, all_of: array(double)): boolean = count(r > low for r in all_of) > n
function most(limit: double, r: array(double)): double = max(d for d in r if d < limit)
function far(x: double): boolean = x > 2 * low
"""
FIRST = {"VALUE": "value.at.x", "TEST": "value.at.y > 1", "NEEDS": "true", "DATA": "1.0"}

SAME = [
    ("VALUE", "quarter(value.at.x)", "value.at.x / 2 / 2"),
    ("VALUE", "half(1)", "1.0 / 2"),
    ("VALUE", "nearest(value.ranges)", "min(d for d in value.ranges if d > low) else 0.0"),
    ("VALUE", "left(value)", "value.ranges[0] + value.at.x"),
    ("VALUE", "at_x(value.at, front)", "value.at.x + front"),
    ("VALUE", "half(value.ranges[0]) else 1.0", "value.ranges[0] / 2 else 1.0"),
    ("VALUE", "sum(half(w) for w in value.weights)", "sum(w / 2 for w in value.weights)"),
    # The variable of an aggregate in the body is not that of one around the call.
    (
        "VALUE",
        "sum(most(d, value.ranges) for d in value.weights)",
        "sum(max(d_ for d_ in value.ranges if d_ < d) for d in value.weights)",
    ),
    ("TEST", "above(2, value.ranges)", "count(r > low for r in value.ranges) > 2"),
    ("TEST", "far(value.at.y)", "value.at.y > 2 * low"),
    ("NEEDS", "far(Laser.front)", "Laser.front > 2 * low"),
    ("NEEDS", "!far(quarter(Laser.front))", "!(Laser.front / 2 / 2 > 2 * low)"),
    ("DATA", "scaled(Laser.front)", "Laser.front * gain + low"),
]

COPIES = """
    component Gauge[1..2] {
        function scaled(x: double, y: double): double = x * index + y
        incoming message go with identifier: "/go{index}", type: double
        behaviour { variable d: double initial marked state s { on request to go do d := value } }
    }
    stop with nothing
    for i in 1..2 {
        requirement Gauge[i].go needs NEEDS
        provide Gauge[i].go with DATA
    }
"""


def model(functions: str = "", **parts: str) -> str:
    text = ROBOT.replace("FUNCTIONS", functions)
    for name, part in {**FIRST, **parts}.items():
        text = text.replace(name, part)
    return text


def meant(robot: Robot) -> tuple[object, ...]:
    """What of a robot does not depend on how it is written."""
    assignments = [
        assignment.value
        for component in robot.components
        for transition in component.transitions
        for assignment in transition.assignments
    ]
    return (assignments, [r.condition for r in robot.requirements], robot.provides)


@pytest.mark.parametrize(("place", "call", "written_out"), SAME)
def test_a_call_is_its_body_with_the_arguments(place: str, call: str, written_out: str) -> None:
    called = resolve(model(FUNCTIONS, **{place: call}))
    expected = resolve(model(**{place: written_out}))
    assert meant(called) == meant(expected)


@pytest.mark.parametrize(
    ("call", "written_out"),
    [
        ("Gauge[1].scaled(2, 3)", "2.0 * 1 + 3.0"),
        ("Gauge[i].scaled(Gauge[i].d, 1)", "Gauge[i].d * i + 1.0"),
        ("1 + Gauge[i + 1 - 1].scaled(2, 3)", "1 + (2.0 * i + 3.0)"),
        ("Gauge[2].scaled(2, Gauge[1].scaled(3, 4))", "2.0 * 2 + (3.0 * 1 + 4.0)"),
        ("sum(g.scaled(2, 1) for g in Gauge)", "(2.0 * 1 + 1.0) + (2.0 * 2 + 1.0)"),
    ],
)
def test_a_copy_has_its_own_function(call: str, written_out: str) -> None:
    def robot(data: str) -> tuple[object, ...]:
        return meant(resolve(COPIES.replace("NEEDS", f"{data} > 4").replace("DATA", data)))

    assert robot(call) == robot(written_out)


@pytest.mark.parametrize(
    ("call", "code", "marked"),
    [
        ("Gauge[3].scaled(1, 2)", "bad-index", "Gauge[3].scaled"),
        ("Gauge[Gauge[1].d].scaled(1, 2)", "bad-index", "Gauge[1].d"),
        ("Gauge[1].skaled(1, 2)", "unknown-name", "Gauge[1].skaled"),
        ("Gauge[1].d.scaled(1, 2)", "unknown-name", "Gauge[1].d.scaled"),
        ("Gauge[1][2].scaled(1, 2)", "unknown-name", "Gauge[1][2].scaled"),
        ("Gauge[1].scaled(1)", "type-mismatch", "Gauge[1].scaled(1)"),
        ("[1.0][0].scaled(1, 2)", "syntax", "("),
    ],
)
def test_wrong_calls_of_copies(call: str, code: str, marked: str) -> None:
    text = COPIES.replace("NEEDS", "true").replace("DATA", f"0.5 + {call}")
    assert (code, marked) in faults(text)


@pytest.mark.parametrize(
    ("function", "call", "code"),
    [
        ("function f(x: double): double = f(x)", "f(1)", "initial-not-constant"),
        (
            "function f(x: double): double = g(x) function g(x: double): double = f(x)",
            "f(1)",
            "initial-not-constant",
        ),
        ("function abs(x: double): double = x", "abs(1)", "duplicate-name"),
        ("function Scan(x: double): double = x", "1.0", "duplicate-name"),
        (
            "function f(x: double): double = x function f(y: double): double = y",
            "f(1)",
            "duplicate-name",
        ),
        ("function f(x: double, x: double): double = x", "f(1, 2)", "duplicate-name"),
        ("function f(x: double): boolean = x", "1.0", "type-mismatch"),
        ("function f(x: double): double = y", "f(1)", "unknown-name"),
        ("function f(x: double): double = Laser.front", "f(1)", "unknown-name"),
        ("condition c = Laser.on function f(x: boolean): boolean = c", "1.0", "unknown-name"),
        ("function f(x: double): double = value", "f(1)", "value-not-allowed"),
        ("function f(x: Nothing): double = 1.0", "1.0", "unknown-type"),
        ("function f(x: double): double = x", "f()", "type-mismatch"),
        ("function f(x: double): double = x", "f(1, 2)", "type-mismatch"),
        ("function f(x: double): double = x", "f(true)", "type-mismatch"),
        ("function f(x: double): double = x.y", "1.0", "unknown-member"),
        ("function f(r: array(double)): double = r[3]", "f([1.0])", "type-mismatch"),
        ("function f(x: double): double = x", "1.0", "unused-value"),
        ("function f(x: double): double = x", "Laser.f(1)", "unknown-name"),
    ],
)
def test_faults(function: str, call: str, code: str) -> None:
    assert code in [found for found, _ in faults(model(function, DATA=call))]


@pytest.mark.parametrize("times", [1, 2])
def test_many_functions_in_each_other_end_with_a_message(times: int) -> None:
    chain = "".join(
        f"function f{n}(x: double): double = {' + '.join([f'f{n - 1}(x)'] * times)} "
        for n in range(1, 80)
    )
    found = faults(model(f"function f0(x: double): double = x {chain}", DATA="f79(1)"))
    assert "too-deep" in [code for code, _ in found]


LIBRARY = """library Site {
    constant least: double = 0.1
    function above(x: double): boolean = x > least
    component Lamp {
        incoming message on with identifier: "on", type: double
        parameter level: double = 0.5
        function dimmed(x: double): double = x * level
        provide on with dimmed(0.5) if above(0.2)
    }
}
"""


def test_functions_of_libraries_and_components(tmp_path: Path) -> None:
    (tmp_path / "site.rscd").write_text(LIBRARY)
    path = tmp_path / "model.rscd"

    def read(calls: bool) -> Robot:
        test, data = ("Site.above(Base.v)", "Lamp.dimmed(Base.v)") if calls else (
            "Base.v > Site.least", "Base.v * Lamp.level"
        )  # fmt: skip
        path.write_text(f"""robot R {{
            component Lamp from Site import Lamp
            component Base {{
                incoming message drive with type: double
                outgoing message speed with timeout: 1 s, type: double
                behaviour {{
                    variable v: double
                    initial marked state s {{ on response from speed do v := value }}
                }}
            }}
            requirement drive needs speed.fresh and {test}
            provide drive with {data}
            stop with drive
        }}""")
        robot, found = load(str(path), (), MessageDefinitions.for_model(path, {}))
        assert robot is not None, render_all(found)
        return robot

    assert meant(read(calls=True)) == meant(read(calls=False))
