"""Constants and named conditions: where they are seen, what they mean, what is wrong with them."""

from __future__ import annotations

from pathlib import Path

import pytest
from model_text import faults, resolve

from robosc.errors import render_all
from robosc.model.resolve import load
from robosc.plant.model_text import to_dsl

ROBOT = """
constant limit: double = 2 * half
constant half: integer = 2
constant mine: Way = near
condition safe = Sensor.ready and Sensor.way != mine
datatype object Spot { x: double y: double }
datatype enum Way from double to { value > limit -> far default -> near }
component Sensor {
    constant least: integer = 3
    condition ready = watching and n >= least
    incoming message go with type: double
    outgoing message scan with type: Way
    behaviour {
        variable n: integer(0..9) = least
        variable way: Way = mine
        initial marked state watching { on response from scan if n < least do way := value }
    }
}
%s
"""


def meaning(text: str) -> str:
    robot = resolve(ROBOT % f"requirement go needs {text}")
    return to_dsl(robot.requirements[0].condition, robot)


@pytest.mark.parametrize(
    ("written", "meant"),
    [
        ("safe", "Sensor.watching and Sensor.n >= 3 and Sensor.way != near"),
        ("!safe", "!(Sensor.watching and Sensor.n >= 3 and Sensor.way != near)"),
        ("Sensor.ready", "Sensor.watching and Sensor.n >= 3"),
        ("Sensor.n > limit - half", "Sensor.n > 4.0 - 2"),
        ("Sensor.n in {Sensor.least, half}", "Sensor.n = 3 or Sensor.n = 2"),
        ("Sensor.way = mine", "Sensor.way = near"),
    ],
)
def test_a_name_means_its_value(written: str, meant: str) -> None:
    assert meaning(written) == meant


def test_values_stand_in_rules_initial_values_and_data() -> None:
    robot = resolve(ROBOT % "provide go with limit + half")
    behaviour = robot.component("Sensor").behaviour
    assert [variable.initial for variable in behaviour.variables] == [3, "near"]
    rule = robot.communications["Sensor.scan"].response.rules[0]
    assert to_dsl(rule.condition, robot) == "value > 4.0"
    assert to_dsl(robot.provides[0].data, robot) == "4.0 + 2"


WHOLES = """
    interface links use Plan from nowhere_msgs
    datatype object Plan { to: Spot via: array(Spot) weights: array(double) }
    datatype object Spot { x: double y: double }
    constant home: Spot = { x: 1.5, y: 2 }
    constant route: array(Spot) = [home, { y: -1.0 }]
    component Base {
        incoming message go with type: Plan links links
        constant weights: array(double) = [0.5, 1]
        outgoing message level with type: double
        behaviour {
            variable l: double = weights[1]
            initial marked state on { on response from level do l := value }
        }
    }
    requirement go needs Base.l > home.y and any(w < Base.l for w in Base.weights)
    provide go with { to: home, via: route, weights: Base.weights } if Base.l > route[1].y
    provide go with { to: route[0], weights: [Base.weights[0], count(w > 0 for w in [1, 2])] }
"""


def test_constants_may_be_objects_and_arrays() -> None:
    robot = resolve(WHOLES)
    home = {"x": 1.5, "y": 2.0}
    first, second = (dict(p.data.fields) for p in robot.provides)
    assert first["to"].value == home
    assert first["via"].value == (home, {"y": -1.0})
    assert first["weights"].value == (0.5, 1.0)
    assert second["to"].value == home
    assert to_dsl(first["via"], robot) == "[{ x: 1.5, y: 2.0 }, { y: -1.0 }]"
    assert to_dsl(robot.provides[0].condition, robot) == "Base.l > -1.0"
    (variable,) = robot.component("Base").behaviour.variables
    assert variable.initial == 1.0
    (requirement,) = robot.requirements
    text = "Base.l > 2.0 and any(w < Base.l for w in [0.5, 1.0])"
    assert to_dsl(requirement.condition, robot) == text


@pytest.mark.parametrize(
    ("declaration", "fault"),
    [
        ("constant a: integer = b constant b: integer = a + 1", ("initial-not-constant", "a")),
        ("constant a: integer(0..3) = 7", ("out-of-range", "7")),
        ("constant a: boolean = 3", ("type-mismatch", "3")),
        ("constant a: double = 1 / 0", ("initial-not-constant", "1 / 0")),
        (
            "constant a: integer = 1 - 9999999999 * 9999999999",
            ("number-too-large", "1 - 9999999999 * 9999999999"),
        ),
        ("constant half: integer = 3", ("duplicate-name", "half")),
        ("constant a: none = 3", ("variable-type", "none")),
        ("parameter a: array(double) = [true]", ("type-mismatch", "true")),
        ("constant a: array(double) = 3", ("type-mismatch", "3")),
        ("constant a: array(double) = [0.5, true]", ("type-mismatch", "true")),
        ("constant a: array(double) = { x: 3 }", ("type-mismatch", "{")),
        ("constant a: Spot = { x: 1, z: 2 }", ("unknown-property", "z")),
        ("constant a: Spot = { x: 1, x: 2 }", ("duplicate-name", "x")),
        ("constant a: Spot = { x: Sensor.n }", ("unknown-name", "Sensor")),
        ("constant a: Spot = { x: 1 } condition b = a.y > 0", ("unknown-member", "a.y")),
        ("constant a: array(double) = [1] condition b = a[1] > 0", ("unknown-member", "a[1]")),
        ("constant a: array(double) = [1] condition b = a.x > 0", ("unknown-member", "x")),
        ("condition a = Sensor.n", ("type-mismatch", "Sensor.n")),
        ("condition a = value > 3", ("value-not-allowed", "value")),
        ("condition a = b condition b = !a", ("initial-not-constant", "a")),
        ("condition a = Sensor.most = 3", ("unknown-member", "most")),
        ("requirement go needs save", ("unknown-name", "save")),
    ],
)
def test_a_wrong_declaration_is_marked(declaration: str, fault: tuple[str, str]) -> None:
    assert [f for f in faults(ROBOT % declaration) if not f[0].startswith("unused")] == [fault]


def test_values_of_a_library_have_its_name(tmp_path: Path) -> None:
    (tmp_path / "wheels.rscd").write_text(
        "library Wheels { constant top: double = 2.5 condition moving = Wheel.on_"
        " component Wheel { condition slow = n < few constant few: integer = 2"
        " incoming message roll with type: double outgoing message tick with type: none"
        " behaviour { variable n: integer(0..5) initial marked state on_ {"
        " on response from tick if n > 0 do n := n - 1 } } } }"
    )
    model = tmp_path / "cart.rscd"
    model.write_text(
        "robot Cart { constant half: double = Wheels.top / 2 component Left from Wheels import Wheel"
        " requirement roll needs Left.slow provide roll with half + Wheels.top }"
    )
    robot, diagnostics = load(str(model))
    assert robot is not None, render_all(diagnostics)
    assert to_dsl(robot.requirements[0].condition, robot) == "Left.n < 2"
    assert to_dsl(robot.provides[0].data, robot) == "1.25 + 2.5"


STORED = """
datatype enum Way from double to {{ value > 1 -> far default -> near }}
datatype object Spot {{ x: double {way} }}
constant home: Spot = {{ x: 1 {near} }}
interface link use Spot from nowhere_msgs
component Base {{
    outgoing message here with type: Spot links link
    incoming message go with type: double
    behaviour {{
        variable spot: Spot
        initial marked state on {{ on response from here do spot := home }}
    }}
}}
provide go with Base.spot.x
"""


def test_a_variable_takes_no_constant_with_names_of_enums() -> None:
    """It holds what the enum converts; the constant has the results of conversions."""
    text = STORED.format(way="way: Way", near=", way: near")
    assert ("not-assignable", "home") in faults(text)
    assert "not-assignable" not in dict(faults(STORED.format(way="", near="")))


@pytest.mark.parametrize(
    ("first", "next_", "fault"),
    [
        ("condition c0 = Sensor.ready", "condition c{n} = c{m} and !c{m}", "too-deep"),
        ('constant c0: string = "ab"', "constant c{n}: string = c{m} + c{m}", "out-of-range"),
    ],
)
def test_what_doubles_with_each_declaration_is_bounded(first: str, next_: str, fault: str) -> None:
    doubling = "\n".join(next_.format(n=n, m=n - 1) for n in range(1, 60))
    found = [f for f in faults(ROBOT % f"{first}\n{doubling}") if not f[0].startswith("unused")]
    assert [code for code, _ in found] == [fault]
