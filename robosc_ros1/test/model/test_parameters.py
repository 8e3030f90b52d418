"""Parameters of the node that a model declares, and values that an import sets."""

from __future__ import annotations

from pathlib import Path

import pytest
from model_text import faults, resolve

from robosc.errors import render_all
from robosc.expr.evaluation import evaluate
from robosc.expr.traversal import parameters_of
from robosc.model.declarations.parameters import with_parameters
from robosc.model.entities import Robot
from robosc.model.resolve import load
from robosc.plant.model_text import to_dsl

ROBOT = """
constant margin: double = 0.5
parameter limit: double = 2 * margin
parameter way: Way = far
parameter pause: duration = 2 min
datatype enum Way from double to { value > limit -> far default -> near }
component Sensor {
    parameter least: integer(0..5) = 3
    parameter silence: duration = 500 ms
    incoming message go with type: double
    outgoing message scan with timeout: silence, type: Way
    behaviour {
        variable way: Way
        initial marked state watching {
            on response from scan do way := value
            after pause goto watching
        }
    }
}
%s
"""


def keys(robot: Robot) -> list[tuple[str, str, object]]:
    return [(p.name, str(p.type), p.default) for p in robot.parameters]


def test_parameters_have_names_types_and_defaults() -> None:
    assert keys(resolve(ROBOT % "")) == [
        ("limit", "double", 1.0),
        ("way", "Way", "far"),
        ("pause", "duration", 120.0),
        ("Sensor/least", "integer(0..5)", 3),
        ("Sensor/silence", "duration", 0.5),
    ]


@pytest.mark.parametrize("value", [2**63, -(2**63) - 1])
def test_an_integer_that_ros_cannot_carry_is_refused(value: int) -> None:
    assert faults(f"parameter wide: integer = {value}") == [("out-of-range", str(value))]
    assert ("out-of-range", str(value)) not in faults(f"constant wide: integer = {value}")
    assert faults(f"parameter wide: integer = {2**63 - 1}") == [("unused-value", "wide")]


def test_they_stand_in_conditions_rules_data_and_durations() -> None:
    robot = resolve(
        ROBOT % "requirement go needs Sensor.way = way and Sensor.least > 2 provide go with limit"
    )
    assert to_dsl(robot.requirements[0].condition, robot) == "Sensor.way = way and Sensor.least > 2"
    assert to_dsl(robot.provides[0].data, robot) == "limit"
    rule = robot.communications["Sensor.scan"].response.rules[0]
    assert [p.key for p in parameters_of(rule.condition)] == ["limit"]
    timeout = robot.communications["Sensor.scan"].timeout
    behaviour = robot.component("Sensor").behaviour
    assert timeout is not None
    assert to_dsl(timeout, robot) == "Sensor.silence"
    assert to_dsl(behaviour.states[0].afters[0].delay, robot) == "pause"


def test_durations_may_be_constants_and_those_of_other_components() -> None:
    robot = resolve(
        "constant long: duration = 1 h"
        " component A { outgoing message a with timeout: B.short, type: none }"
        " component B { constant short: duration = 100 ms"
        " outgoing message b with timeout: long, type: none }"
    )
    timeouts = [c.timeout for c in robot.communications.values()]
    assert [None if t is None else evaluate(t, lambda leaf: None) for t in timeouts] == [0.1, 3600]


def test_copies_of_a_component_have_parameters_of_their_own() -> None:
    robot = resolve(
        "component Station[1..2] { parameter limit: double = index"
        " incoming message go with type: double }"
        " requirement Station[2].go needs Station[1].limit < Station[2].limit"
    )
    assert keys(robot) == [("station_1/limit", "double", 1.0), ("station_2/limit", "double", 2.0)]


@pytest.mark.parametrize(
    ("declaration", "fault"),
    [
        ("parameter a: integer(0..3) = 7", ("out-of-range", "7")),
        ("parameter a: boolean = 3", ("type-mismatch", "3")),
        ("parameter a: double = limit", ("initial-not-constant", "limit")),
        ("constant a: double = limit + 1", ("initial-not-constant", "limit + 1")),
        ("parameter a: duration = 3", ("type-mismatch", "3")),
        ("parameter a: duration = 0 s", ("out-of-range", "0 s")),
        ("parameter a: duration = -2 s", ("out-of-range", "-2 s")),
        ("parameter a: duration = 0.0001 ms", ("out-of-range", "0.0001 ms")),
        (
            "constant a: duration = -2 s"
            " component C { outgoing message c with timeout: a, type: none }",
            ("out-of-range", "a"),
        ),
        (
            "constant a: duration = 0 s"
            " component C { behaviour { initial marked state s { after a goto s } } }",
            ("out-of-range", "a"),
        ),
        ("parameter a: double = 2 s", ("type-mismatch", "2 s")),
        ("parameter a: array(Way) = 3", ("variable-type", "array(Way)")),
        ("parameter a: array(double) = 3", ("type-mismatch", "3")),
        ("constant limit: integer = 3", ("duplicate-name", "limit")),
        ("parameter seed: integer = 3", ("parameter-name", "seed")),
        ("component C { parameter a: Way = limit }", ("type-mismatch", "limit")),
        ("requirement go needs Sensor.most", ("unknown-member", "most")),
        ("requirement go needs pause > 3", ("type-mismatch", "pause")),
        ("requirement go needs pause = pause", ("type-mismatch", "pause")),
        (
            "component C { outgoing message c with timeout: limit, type: none }",
            ("type-mismatch", "limit"),
        ),
        (
            "component C { parameter least: integer(0..3) = 1"
            " behaviour { variable v: integer(0..3) = least"
            " initial marked state s { transition if v = 1 } } }",
            ("initial-not-constant", "least"),
        ),
        (
            "component C { outgoing message c with type: duration }",
            ("unknown-type", "duration"),
        ),
    ],
)
def test_a_wrong_declaration_is_marked(declaration: str, fault: tuple[str, str]) -> None:
    assert [f for f in faults(ROBOT % declaration) if not f[0].startswith("unused")] == [fault]


LIBRARY = """library Wheels {
    constant top: double = 2.5
    parameter grip: double = 0.8
    datatype enum Pace from double to { value > grip -> fast default -> slow }
    component Wheel {
        constant radius: double = 0.1
        parameter limit: integer(0..9) = 5
        parameter wait: duration = 1 s
        incoming message roll with type: double
        outgoing message pace with timeout: wait, type: Pace
        behaviour {
            variable pace: Pace
            variable count: integer(0..9)
            initial marked state on_ {
                on response from pace do pace := value
                on request to roll if count < limit do count := count + 1
                on timeout from pace do count := 0
            }
        }
    }
}
"""


def imported(tmp_path: Path, robot: str, library: str = LIBRARY) -> tuple[Robot | None, str]:
    (tmp_path / "wheels.rscd").write_text(library)
    model = tmp_path / "cart.rscd"
    model.write_text(f"robot Cart {{ {robot} }}")
    found, diagnostics = load(str(model))
    return found, render_all(diagnostics)


def test_an_import_sets_constants_and_defaults_of_parameters(tmp_path: Path) -> None:
    robot, told = imported(
        tmp_path,
        "constant big: double = 0.5"
        ' component Left from Wheels import Wheel with prefix: "/left", radius: 2 * big, limit: 3'
        ' component Right from Wheels import Wheel with prefix: "/right", wait: 20 ms'
        " provide Left.roll with Left.radius provide Right.roll with Right.radius",
    )
    assert robot is not None, told
    assert keys(robot) == [
        ("Left/limit", "integer(0..9)", 3),
        ("Left/wait", "duration", 1.0),
        ("Right/limit", "integer(0..9)", 5),
        ("Right/wait", "duration", 0.02),
        ("Wheels/grip", "double", 0.8),
    ]
    assert [to_dsl(p.data, robot) for p in robot.provides] == ["1.0", "0.1"]


def test_an_import_of_an_import_keeps_what_the_first_one_sets(tmp_path: Path) -> None:
    (tmp_path / "axles.rscd").write_text(
        "library Axles { component Front from Wheels import Wheel with limit: 2, radius: 0.3 }"
    )
    robot, told = imported(
        tmp_path,
        "component Axle from Axles import Front with limit: 1 provide roll with Axle.radius",
    )
    assert robot is not None, told
    assert keys(robot)[0] == ("Axle/limit", "integer(0..9)", 1)
    assert to_dsl(robot.provides[0].data, robot) == "0.3"


def test_several_imports_take_their_index(tmp_path: Path) -> None:
    robot, told = imported(
        tmp_path,
        'component Wheel[1..2] from Wheels import Wheel with prefix: "/w{index}", limit: 2 * index',
    )
    assert robot is not None, told
    assert [k for k in keys(robot) if k[0].endswith("limit")] == [
        ("wheel_1/limit", "integer(0..9)", 2),
        ("wheel_2/limit", "integer(0..9)", 4),
    ]


@pytest.mark.parametrize(
    ("argument", "told"),
    [
        ("radios: 1.0", "Wheel has no constant or parameter 'radios'"),
        ("count: 1", "Wheel has no constant or parameter 'count'"),
        ("limit: 11", "11 is outside the range of parameter 'limit'"),
        ("limit: 1.5", "parameter 'limit' needs an integer(0..9), this is a double"),
        ("limit: 1, limit: 2", "another argument is already called 'limit'"),
        ("wait: 3", "parameter 'wait' needs a duration, this is an integer"),
    ],
)
def test_a_wrong_argument_is_marked(tmp_path: Path, argument: str, told: str) -> None:
    robot, text = imported(tmp_path, f"component Left from Wheels import Wheel with {argument}")
    assert robot is None
    assert told in text and "cart.rscd" in text


def test_types_of_a_library_have_its_name(tmp_path: Path) -> None:
    robot, told = imported(
        tmp_path,
        "component Left from Wheels import Wheel"
        " component Other { outgoing message other with type: Wheels.Pace"
        " behaviour { variable pace: Wheels.Pace"
        " initial marked state s { on response from other do pace := value } } }"
        " requirement roll needs Other.pace = slow and Wheels.Pace(0.3) = slow",
    )
    assert robot is not None, told
    assert str(robot.communications["Other.other"].response) == "Pace"


@pytest.mark.parametrize(
    ("type_", "told"),
    [
        ("Wheels.Pase", "library Wheels has no datatype 'Pase'"),
        ("Weels.Pace", "nothing is imported from a library 'Weels'"),
    ],
)
def test_a_wrong_type_of_a_library_is_marked(tmp_path: Path, type_: str, told: str) -> None:
    robot, text = imported(
        tmp_path,
        "component Left from Wheels import Wheel"
        f" component Other {{ outgoing message other with type: {type_} }}",
    )
    assert robot is None
    assert told in text


def test_other_defaults_reach_every_expression() -> None:
    robot = resolve(ROBOT % "provide go with limit")
    chosen = with_parameters(robot, {"limit": 7.0, "Sensor/least": 1, "rate": 3.0})
    assert keys(chosen)[0] == ("limit", "double", 7.0)
    rule = chosen.communications["Sensor.scan"].response.rules[0]
    assert [p.default for p in parameters_of(rule.condition)] == [7.0]
    assert evaluate(chosen.provides[0].data, lambda leaf: None) == 7.0
    assert with_parameters(robot, {"rate": 3.0}) is robot
