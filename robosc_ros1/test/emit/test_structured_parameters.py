"""Parameters that are arrays or objects: in the model, in the controller, and as ROS gives them."""

from __future__ import annotations

from typing import Any

import pytest
import yaml
from emit.generated_code import controller_class, supervisor_of
from emit.scripted_controllers import faults_of
from model.model_text import faults
from simulate.players import play, session

from robosc.emit.package.config import Config, declared_communications, declared_parameters
from robosc.emit.package.ros1_target import emit as emit_ros1
from robosc.emit.package.ros2_target import emit as emit_ros2
from robosc.model.declarations.parameters import with_parameters
from robosc.runtime.core.launch_arguments import parts_by_name
from robosc.runtime.core.settings import ParameterError, dotted, flatten, private, read
from robosc.source import Source
from robosc.syntax.formatting.format import format_text

MODEL = """
datatype object Point { x: double y: double }
datatype object Pose { position: Point name: string }
datatype object Path { poses: array(Pose) levels: array(double) home: Point }
interface path use Path from example_msgs
parameter route: array(Point) = [{ x: 1.0 }, { x: 3.0, y: 2.0 }]
parameter home: Point = { y: -1.0 }
parameter levels: array(double) = [1, 2.5]
parameter nothing: array(integer) = []
component A {
    parameter gate: Pose = { name: "gate" }
    outgoing message next with type: integer(0..3)
    incoming message go with type: Path links path
    incoming message come with type: none
    behaviour {
        variable n: integer(0..3)
        initial marked state on { on response from next do n := value }
    }
}
provide go with { poses: [{ position: p } for p in route if p.x > 1], levels: levels, home: home }
requirement go needs route[A.n].x > 2
requirement come needs A.n > length(levels) + length(nothing) or A.gate.position.x > home.y + 1
"""
ROBOT = "robot R { %s }"


def settings_of(given: Any, spelled: Any = private) -> dict[str, Any]:
    robot = supervisor_of(ROBOT % MODEL).plant.robot
    found, warnings = read(
        declared_communications(robot), flatten(given), declared_parameters(robot), spelled
    )
    assert warnings == []
    return dict(found.more)


def test_fields_that_are_left_out_have_defaults() -> None:
    assert settings_of({"route": [{"y": 1}], "A": {"gate": {"position": {"x": 2}}}}) == {
        "route": [{"x": 0.0, "y": 1.0}],
        "home": {"x": 0.0, "y": -1.0},
        "levels": [1.0, 2.5],
        "nothing": [],
        "A/gate": {"position": {"x": 2.0, "y": 0.0}, "name": ""},
    }


@pytest.mark.parametrize(
    "given",
    [
        {"route": [{"x": 5.0, "y": 6.0}, {"x": 7.0}], "levels": [4, 5.5]},
        {"route": {"0": {"x": 5.0, "y": 6.0}, "1": {"x": 7.0}}, "levels": {"0": 4, "1": 5.5}},
    ],
)
def test_arrays_are_whole_or_given_by_the_names_of_their_parts(given: Any) -> None:
    found = settings_of(given)
    assert found["route"] == [{"x": 5.0, "y": 6.0}, {"x": 7.0, "y": 0.0}]
    assert found["levels"] == [4.0, 5.5]


def test_the_names_of_parts_give_the_value_again() -> None:
    value = settings_of({})
    parts = dict(part for name, whole in value.items() for part in parts_by_name(name, whole))
    assert parts["route/1/x"] == 3.0 and parts["levels"] == [1.0, 2.5]
    robot = supervisor_of(ROBOT % MODEL).plant.robot
    found, _ = read(declared_communications(robot), parts, declared_parameters(robot))
    assert found.more == value


@pytest.mark.parametrize(
    ("given", "told"),
    [
        ({"route": 3}, "~route must be an array, not 3"),
        ({"route": [1]}, "~route[0] must be an object with x, y, not 1"),
        ({"route": [{"x": 1}, {"z": 2}]}, "~route[1] must be an object with x, y, not {'z': 2}"),
        ({"route": {"0": {"x": 1}, "2": {"x": 1}}}, "~route must be an array, not"),
        ({"home": {"x": "a"}}, "~home.x must be a number, not 'a'"),
        ({"home": [1, 2]}, "~home must be an object with x, y, not [1, 2]"),
        ({"levels": [1, float("nan")]}, "~levels[1] must be a number, not nan"),
        (
            {"levels": [1, "1e-5"]},
            "~levels[1] must be a number (in YAML with a point: 1.0e-5), not '1e-5'",
        ),
        ({"nothing": [1.5]}, "~nothing[0] must be an integer, not 1.5"),
        ({"A": {"gate": {"name": 3}}}, "~A/gate.name must be a string (in quotes), not 3"),
    ],
)
def test_wrong_shapes_are_refused_by_name(given: Any, told: str) -> None:
    with pytest.raises(ParameterError) as error:
        settings_of(given)
    assert f"parameter {told}" in str(error.value)


def test_the_controller_sends_what_the_parameters_hold() -> None:
    controller = controller_class(supervisor_of(ROBOT % MODEL))[0]()
    assert controller.data_for_go()["levels"] == [1.0, 2.5]
    assert vars(controller.data_for_go()["home"]) == {"x": 0.0, "y": -1.0}
    assert not controller.can_request_go()
    controller.configure(settings_of({"route": [{"x": 9.0}, {"x": 1.0}, {"x": 4.0, "y": 8.0}]}))
    assert controller.can_request_go()
    sent = controller.data_for_go()["poses"]
    assert [vars(pose["position"]) for pose in sent] == [{"x": 9.0, "y": 0.0}, {"x": 4.0, "y": 8.0}]


@pytest.mark.parametrize("engine", ["explicit", "bdd"])
def test_conditions_read_parameters(engine: str) -> None:
    player = session(supervisor_of(ROBOT % MODEL, engine=engine), execute=True)
    play(player, "expect disabled go", "next 1", "expect enabled go", "expect disabled come")
    play(player, "next 3", "expect disabled go", "expect enabled come")


@pytest.mark.parametrize("route", [None, [{"x": 3.0}], []])
def test_the_test_of_the_package_reads_them_the_same_way(route: Any) -> None:
    supervisor = supervisor_of(ROBOT % MODEL)
    changed = {} if route is None else {"route": route}
    robot = with_parameters(supervisor.plant.robot, changed)
    assert next(p.default for p in robot.parameters if p.name == "route") == tuple(
        {"x": 0.0, "y": 0.0, **point}
        for point in ([{"x": 1.0}, {"x": 3.0, "y": 2.0}] if route is None else route)
    )
    assert faults_of(supervisor) == []


@pytest.mark.parametrize("emit", [emit_ros1, emit_ros2])
def test_the_files_of_a_package(emit: Any) -> None:
    supervisor = supervisor_of(ROBOT % MODEL)
    files = emit(supervisor, "pack", Config()).files
    text = files["config/pack.yaml"].content
    document = yaml.safe_load(text)
    if emit is emit_ros1:
        assert settings_of(document) == settings_of({})
        launch = files["launch/pack.launch"].content
        assert '<rosparam param="route" subst_value="true"' in launch
    else:
        # Files of ROS 2 have no arrays of objects, and no empty ones.
        own = document["/**"]["ros__parameters"]
        assert not {"route", "nothing"} & {*own}
        assert own["levels"] == [1.0, 2.5] and own["home"] == {"x": 0.0, "y": -1.0}
    given = settings_of({"home": {"x": 4.0}}, dotted)
    assert given["home"] == {"x": 4.0, "y": 0.0}


@pytest.mark.parametrize(
    ("declaration", "fault"),
    [
        ("parameter p: array(Point) = [{ z: 1 }]", ("unknown-property", "z")),
        ("parameter p: Point = 3", ("type-mismatch", "3")),
        ("parameter p: array(Way) = [a]", ("variable-type", "array(Way)")),
        (
            "parameter p: array(double) = [length(levels)]",
            ("initial-not-constant", "length(levels)"),
        ),
    ],
)
def test_faults_of_declarations(declaration: str, fault: tuple[str, str]) -> None:
    way = "datatype enum Way from double to { value > 1 -> a default -> b }"
    assert fault in faults(f"{MODEL} {way} {declaration}")


def test_the_layout_of_parameters() -> None:
    text = "robot R{parameter p:array(P)=[{x:1.0},{x:2.0}] parameter q:P={x:1.0}}"
    found = format_text(Source("m", text))
    assert "parameter p: array(P) = [{ x: 1.0 }, { x: 2.0 }]\n" in found
    assert "parameter q: P = { x: 1.0 }\n" in found


REQUIRED = ROBOT % (
    """
    datatype object Point { x: double y: double }
    parameter route: array(Point)
    component A {
        parameter home: Point
        incoming message go with type: double
        incoming message come with type: double
    }
    provide go with route[0].x
    provide come with A.home.y
    """
)


def test_what_has_no_value_must_be_given() -> None:
    robot = supervisor_of(REQUIRED).plant.robot
    communications, parameters = declared_communications(robot), declared_parameters(robot)
    with pytest.raises(ParameterError) as fault:
        read(communications, {}, parameters)
    assert str(fault.value).splitlines() == [
        "parameter ~route must be given: the model has no value for it",
        "parameter ~A/home must be given: the model has no value for it",
    ]
    given = {"route/0/x": 2.0, "A/home": {"y": 1}}
    found, _ = read(communications, given, parameters)
    assert found.more == {"route": [{"x": 2.0, "y": 0.0}], "A/home": {"x": 0.0, "y": 1.0}}


def test_packages_and_their_tests_say_so() -> None:
    supervisor = supervisor_of(REQUIRED)
    one, two = emit_ros1(supervisor, "tour"), emit_ros2(supervisor, "tour")
    assert "# route: [" in one.files["config/tour.yaml"].content
    assert "    # A.home: {" in two.files["config/tour.yaml"].content
    assert "| `route` | array | none |" in one.files["README.md"].content
    for package in (one, two):
        under_test = package.files["test/robot_tables.py"].content
        assert "route" in under_test and "home" in under_test
    # The configuration may give it for all that run the package.
    configured = emit_ros1(supervisor, "tour", Config(parameters={"route": [{"x": 1.0}]}))
    assert "\nroute: [" in configured.files["config/tour.yaml"].content


@pytest.mark.parametrize(
    "declared",
    [
        "parameter n: integer",
        "parameter n: duration",
        "datatype enum E from integer to { value > 1 -> a default -> b } parameter n: E",
    ],
)
def test_what_is_neither_array_nor_object_needs_a_value(declared: str) -> None:
    assert ("initial-not-constant", "n") in faults(declared)


def test_its_layout() -> None:
    found = format_text(Source("m", REQUIRED))
    assert found is not None and "    parameter route: array(Point)\n" in found
