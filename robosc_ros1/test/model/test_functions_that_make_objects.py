"""A call of a function that returns an object means the object with the arguments in it."""

from __future__ import annotations

from pathlib import Path

import pytest
from model.model_text import faults, resolve

from robosc import pipeline
from robosc.errors import ModelError

ROBOT = """
datatype object Spot { x: double y: double near: boolean }
datatype object Line { from_: Spot to_: Spot all_of: array(Spot) }
interface point use Point from geometry_msgs
constant home: Spot = CONSTANT
FUNCTIONS
component Base {
    outgoing message at with timeout: 1 s, type: Spot links spots
    incoming message go with type: Spot links spots
    incoming message way with type: Line links lines
    behaviour {
        variable last: Spot
        variable front: double
        initial marked state on { on response from at do last := value, front := VALUE }
    }
}
interface spots use Spot from spot_msgs
interface lines use Line from spot_msgs
requirement go needs at.fresh and NEEDS
provide go with DATA
provide way with WAY
stop with go
"""
FUNCTIONS = """
function spot(x: double): Spot = { x: x, y: 2.0 * x }
function half(p: Spot): Spot = { x: p.x / 2, y: p.y / 2 }
function line(a: Spot, b: Spot): Line = { from_: a, to_: half(b), all_of: [half(a), { x: 1.0 }] }
function shifted(p: Spot, by: double): Spot = { x: p.x + by, near: p.near }
"""
FIRST = {
    "CONSTANT": "{ x: 3.0, y: 1.0 }",
    "VALUE": "0.0",
    "NEEDS": "true",
    "DATA": "{ x: 1.0 }",
    "WAY": "{ }",
}
SAME = [
    ("DATA", "spot(Base.front)", "{ x: Base.front, y: 2.0 * Base.front }"),
    ("DATA", "spot(1)", "{ x: 1.0, y: 2.0 * 1.0 }"),
    ("DATA", "half(Base.last)", "{ x: Base.last.x / 2, y: Base.last.y / 2 }"),
    ("DATA", "half(spot(Base.front))", "{ x: Base.front / 2, y: 2.0 * Base.front / 2 }"),
    ("DATA", "half(home)", "{ x: home.x / 2, y: home.y / 2 }"),
    # What a function does not name is what a message begins with.
    ("DATA", "shifted(spot(1.5), 2)", "{ x: 1.5 + 2.0, near: false }"),
    (
        "WAY",
        "line(Base.last, spot(4.0))",
        "{ from_: Base.last, to_: { x: 4.0 / 2, y: 2.0 * 4.0 / 2 },"
        " all_of: [{ x: Base.last.x / 2, y: Base.last.y / 2 }, { x: 1.0 }] }",
    ),
    ("NEEDS", "half(Base.last).x < 3.0", "Base.last.x / 2 < 3.0"),
    ("NEEDS", "spot(2.0).y > Base.front and !spot(1).near", "2.0 * 2.0 > Base.front and !false"),
    ("VALUE", "half(value).y", "value.y / 2"),
    ("CONSTANT", "spot(3)", "{ x: 3.0, y: 6.0 }"),
]


def model(**parts: str) -> str:
    text = ROBOT.replace("FUNCTIONS", FUNCTIONS)
    for name, part in (FIRST | parts).items():
        text = text.replace(name, part)
    return text


@pytest.mark.parametrize(("place", "call", "written"), SAME)
def test_a_call_means_the_object(place: str, call: str, written: str) -> None:
    called, expected = resolve(model(**{place: call})), resolve(model(**{place: written}))
    assert called.provides == expected.provides
    assert [r.condition for r in called.requirements] == [
        r.condition for r in expected.requirements
    ]
    assert [c.behaviour for c in called.components] == [c.behaviour for c in expected.components]


@pytest.mark.parametrize(
    ("function", "code"),
    [
        ("function bad(x: double): Spot = { z: x }", "unknown-property"),
        ("function bad(x: double): Spot = x", "type-mismatch"),
        ("function bad(x: double): double = { x: x }", "type-mismatch"),
        ("function bad(x: double): Spot = { x: Base.front }", "unknown-name"),
        ("function bad(x: double): Spot = { x: 1.0, x: x }", "duplicate-name"),
        ("function bad(x: double): Spot = bad(x)", "initial-not-constant"),
    ],
)
def test_faults_are_told_where_the_function_is_declared(function: str, code: str) -> None:
    text = model().replace("function spot", f"{function}\nfunction spot")
    assert code in [found for found, _ in faults(text)]


LIBRARY = """library Geo {
    constant limit: double = 2.0
    datatype enum Side from double to { value < limit -> near default -> far }
    function twice(x: double): double = 2.0 * x
    function point(x: double): geometry_msgs/Point = { x: twice(x), y: limit }
}"""
USER = """robot User {
    component Base {
        incoming message go with identifier: "/go", type: geometry_msgs/Point
        outgoing message at with identifier: "/at", type: double
        behaviour {
            variable side: Geo.Side
            variable d: double
            initial marked state a {
                on response from at do side := Geo.Side(value), d := value
                on request to go
            }
        }
    }
    provide go with Geo.point(Base.d)
    requirement go needs Base.side = near and Base.d < Geo.twice(Geo.limit)
    stop with nothing
}"""


def test_a_library_is_used_without_a_component_of_it(tmp_path: Path) -> None:
    (tmp_path / "geo.rscd").write_text(LIBRARY, encoding="utf-8")
    (tmp_path / "user.rscd").write_text(USER, encoding="utf-8")
    robot = pipeline.load(tmp_path / "user.rscd").robot
    written = USER.replace("Geo.twice(Geo.limit)", "2.0 * 2.0")
    written = written.replace("Geo.point(Base.d)", "{ x: 2.0 * Base.d, y: 2.0 }")
    (tmp_path / "user.rscd").write_text(written, encoding="utf-8")
    expected = pipeline.load(tmp_path / "user.rscd").robot
    assert robot.requirements[0].condition == expected.requirements[0].condition
    assert robot.provides == expected.provides
    (tmp_path / "user.rscd").write_text(USER.replace("Geo.limit", "Geo.bound"), encoding="utf-8")
    with pytest.raises(ModelError, match=r"Geo\.bound"):
        pipeline.load(tmp_path / "user.rscd")


def test_a_name_before_a_dot_need_not_be_a_library(tmp_path: Path) -> None:
    """A fault in a library of that name is none of a robot that has such a component."""
    (tmp_path / "base.rscd").write_text("library Base { faulty }", encoding="utf-8")
    text = USER.replace("Geo.Side(value)", "value").replace("Geo.Side", "double")
    text = text.replace("Geo.point(Base.d)", "{ x: Base.d }").replace("Base.side = near", "true")
    (tmp_path / "user.rscd").write_text(text.replace("Geo.twice(Geo.limit)", "4.0"))
    assert pipeline.load(tmp_path / "user.rscd").robot.requirements
