"""Constants and named conditions: where they are seen, what they mean, what is wrong with them."""

from __future__ import annotations

from pathlib import Path

import pytest
from model_text import faults, resolve

from robosc.errors import render_all
from robosc.ir.expr import to_dsl
from robosc.model.resolve import load

ROBOT = """
constant limit: double = 2 * half
constant half: integer = 2
constant mine: Way = near
condition safe = Sensor.ready and Sensor.way != mine
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
    assert behaviour is not None
    assert [variable.initial for variable in behaviour.variables] == [3, "near"]
    rule = robot.communications["Sensor.scan"].response.rules[0]
    assert to_dsl(rule.condition, robot) == "value > 4.0"
    assert to_dsl(robot.provides[0].data, robot) == "4.0 + 2"


@pytest.mark.parametrize(
    ("declaration", "fault"),
    [
        ("constant a: integer = b constant b: integer = a + 1", ("initial-not-constant", "a")),
        ("constant a: integer(0..3) = 7", ("out-of-range", "7")),
        ("constant a: boolean = 3", ("type-mismatch", "3")),
        ("constant a: double = 1 / 0", ("initial-not-constant", "1 / 0")),
        ("constant half: integer = 3", ("duplicate-name", "half")),
        ("constant a: array(double) = 3", ("variable-type", "array(double)")),
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
