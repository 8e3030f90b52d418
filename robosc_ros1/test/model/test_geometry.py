"""``yaw`` and ``distance`` come to what geometry says, wherever their points come from."""

from __future__ import annotations

import math
from typing import Any

import pytest
from model.model_text import faults, resolve

from robosc.expr.evaluation import evaluate
from robosc.expr.tree import Expr, ValueRef, VariableRef

ROBOT = """
datatype object Point {{ x: double y: double z: double }}
datatype object Quaternion {{ x: double y: double z: double w: double }}
datatype object Pose {{ position: Point orientation: Quaternion name: string path: array(Point) }}
interface pose use Pose from nowhere_msgs
constant home: Point = {{ x: 1.0, y: 2.0, z: 2.0 }}
component Base {{
    outgoing message odom with timeout: 1 s, type: Pose links pose
    behaviour {{
        variable there: Point
        variable found: double
        initial marked state on {{
            on response from odom do found := {expression}, there := value.position
        }}
    }}
}}
component Drive {{ incoming message go with type: none }}
requirement go needs odom.fresh and Base.found < 1.0
"""


def quaternion(roll: float, pitch: float, yaw: float) -> dict[str, float]:
    """The rotation by these angles about the fixed axes, in that order."""
    (cr, sr), (cp, sp), (cy, sy) = (
        (math.cos(angle / 2), math.sin(angle / 2)) for angle in (roll, pitch, yaw)
    )
    return {
        "x": sr * cp * cy - cr * sp * sy,
        "y": cr * sp * cy + sr * cp * sy,
        "z": cr * cp * sy - sr * sp * cy,
        "w": cr * cp * cy + sr * sp * sy,
    }


def found(expression: str, value: Any, there: Any = None) -> Any:
    robot = resolve(ROBOT.format(expression=expression))
    (transition,) = robot.component("Base").transitions
    wanted: Expr = transition.assignments[0].value

    def look(leaf: Any) -> Any:
        match leaf:
            case ValueRef(path=path):
                part = value
                for step in path:
                    part = part[step]
                return part
            case VariableRef():
                return there
        raise AssertionError(leaf)

    return evaluate(wanted, look)


@pytest.mark.parametrize("yaw", [0.0, 0.3, -2.8, 1.5, 3.1])
@pytest.mark.parametrize(("roll", "pitch"), [(0.0, 0.0), (0.2, -0.4), (-1.0, 0.7)])
def test_yaw_is_the_rotation_about_the_upward_axis(roll: float, pitch: float, yaw: float) -> None:
    value = {"orientation": quaternion(roll, pitch, yaw)}
    assert found("yaw(value.orientation)", value) == pytest.approx(yaw)


POINT = {"x": 3.0, "y": -1.0, "z": 8.0}


@pytest.mark.parametrize(
    ("expression", "expected"),
    [
        ("distance(value.position, home)", 7.0),
        ("distance(home, value.position)", 7.0),
        ("distance(value.position, there)", math.dist((3, -1, 8), (0, 0, 0))),
        ("distance(value.path[1], home)", math.dist((5, 5, 5), (1, 2, 2))),
        ("min(distance(p, home) for p in value.path) else 0.0", 3.0),
        ("distance(value.position, value.position)", 0.0),
    ],
)
def test_distance_of_two_points(expression: str, expected: float) -> None:
    path = [{"x": 1.0, "y": 2.0, "z": 5.0}, {"x": 5.0, "y": 5.0, "z": 5.0}]
    value = {"position": POINT, "path": path}
    assert found(expression, value, {"x": 0.0, "y": 0.0, "z": 0.0}) == pytest.approx(expected)


@pytest.mark.parametrize(
    ("expression", "marked"),
    [
        ("yaw(value.position)", "value.position"),
        ("yaw(value)", "value"),
        ("distance(value.position, 3.0)", "3.0"),
        ("distance(value.name, home)", "value.name"),
        ("distance(home)", "distance(home)"),
        ("yaw(value.orientation, home)", "yaw(value.orientation, home)"),
    ],
)
def test_other_arguments(expression: str, marked: str) -> None:
    assert ("type-mismatch", marked) in faults(ROBOT.format(expression=expression))


def test_a_constant_must_have_all_that_is_read() -> None:
    text = ROBOT.replace(", z: 2.0", "").format(expression="distance(value.position, home)")
    assert ("unknown-member", "home") in faults(text)
