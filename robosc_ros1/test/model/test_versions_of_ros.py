"""Definitions of one version of ROS, or of both, in a package for the other one."""

from __future__ import annotations

from pathlib import Path

import pytest
from test_ros_definitions import found, package
from test_ros_types import ROS2

from robosc import pipeline
from robosc.errors import ModelError, Severity
from robosc.model.ros.definitions import MessageDefinitions
from robosc.model.ros.interfaces import Missing
from robosc.model.ros.packages import is_ros2_package

BUILD_TYPE = "<build_type{}>{}</build_type>"
ROS_1 = BUILD_TYPE.format(' condition="$ROS_VERSION == 1"', "catkin")
ROS_2 = BUILD_TYPE.format(' condition="$ROS_VERSION == 2"', "ament_cmake")

MODEL = """
robot Waiter {
    component Feet {
        action walk with identifier: "/walk", type: p/Walk
        behaviour {
            variable late: boolean
            initial marked state on {
                on response from walk do late := value.took.%s > 3
            }
        }
    }
    parameter rest: duration = 1.5 s
    requirement walk needs !Feet.late
    provide walk with { pause: 2.5 s, rest: rest }
}
"""
WALK = "{0} pause\n{0} rest\n---\n{0} took\n---\n"


def manifest(folder: Path, *build_types: str) -> None:
    text = ROS2.format(folder.name).replace(BUILD_TYPE.format("", "ament_cmake"), "{}")
    (folder / "package.xml").write_text(text.format("\n".join(build_types)))


def generated(tmp_path: Path, target: pipeline.Target, field: str) -> str:
    """The controller of the model whose behaviour reads a certain field of a duration."""
    model = tmp_path / "model.rscd"
    model.write_text(MODEL % field)
    output = pipeline.Output(target, tmp_path / "out")
    pipeline.generate(model, pipeline.Options(strict=True), output)
    (controller,) = (tmp_path / "out").rglob("controller.py")
    return controller.read_text()


@pytest.mark.parametrize("written", ["duration", "builtin_interfaces/Duration"])
@pytest.mark.parametrize(
    ("target", "fields", "others"),
    [
        ("ros1", ("secs", "nsecs"), ("sec", "nanosec")),
        ("ros2", ("sec", "nanosec"), ("secs", "nsecs")),
    ],
)
def test_the_target_decides_the_fields_of_durations(
    tmp_path: Path,
    target: pipeline.Target,
    fields: tuple[str, str],
    others: tuple[str, str],
    written: str,
) -> None:
    folder = package(tmp_path, "p", action__Walk=WALK.format(written))
    if written != "duration":
        manifest(folder, BUILD_TYPE.format("", "ament_cmake"))
    controller = generated(tmp_path, target, fields[0])
    for field in fields:
        assert controller.count(f"'{field}'") + controller.count(f'"{field}"') >= 2, controller
    for other in others:
        assert f"'{other}'" not in controller and f'"{other}"' not in controller
    with pytest.raises(ModelError) as fault:
        generated(tmp_path, target, others[0])
    told = [(d.code, d.hint) for d in fault.value.diagnostics if d.severity is Severity.ERROR]
    assert told == [("unknown-member", f"did you mean '{fields[0]}'?")]


def test_a_header_has_a_sequence_number_in_ros_1_only(tmp_path: Path) -> None:
    package(tmp_path, "std_msgs", msg__Header="uint32 seq\ntime stamp\nstring frame_id\n")
    fields = {}
    for version in ("1", "2"):
        definitions = MessageDefinitions.for_model(tmp_path / "m.rscd", {}, version)
        (part,) = found(definitions.interface("std_msgs", "Header", "msg")).parts
        fields[version] = [field.name for field in part.fields]
    assert fields == {"1": ["seq", "stamp", "frame_id"], "2": ["stamp", "frame_id"]}


@pytest.mark.parametrize("build_types", [(ROS_1, ROS_2), (ROS_2,)], ids=["both", "one"])
def test_a_package_of_both_versions_is_read_as_the_target_wants(
    tmp_path: Path, build_types: tuple[str, ...]
) -> None:
    folder = package(tmp_path, "p", action__Walk=f"Header header\n{WALK.format('duration')}")
    manifest(folder, *build_types)
    assert not is_ros2_package(folder, "1")
    assert is_ros2_package(folder, "2")
    model = tmp_path / "m.rscd"
    for definitions in (
        MessageDefinitions.for_model(model, {}, "1"),
        MessageDefinitions.for_model(model, {"ROS_VERSION": "1"}),
        MessageDefinitions.for_model(model, {}),
        MessageDefinitions.for_model(model, {"ROS_VERSION": "2"}, "1"),
    ):
        fields = found(definitions.interface("p", "Walk", "action")).parts[0].fields
        types = [str(field.type) for field in fields]
        assert types == ["std_msgs/Header", "duration", "duration"]
    for definitions in (
        MessageDefinitions.for_model(model, {}, "2"),
        MessageDefinitions.for_model(model, {"ROS_VERSION": "2"}),
    ):
        fields = found(definitions.interface("p", "Walk", "action")).parts[0].fields
        assert str(fields[0].type) == "p/Header"


@pytest.mark.parametrize(
    "build_types",
    [
        (BUILD_TYPE.format("", "catkin"), BUILD_TYPE.format("", "ament_cmake")),
        (BUILD_TYPE.format(' condition="$ROS_VERSION is 2"', "ament_cmake"),),
    ],
    ids=["two", "no condition"],
)
def test_faulty_build_types_are_told(tmp_path: Path, build_types: tuple[str, ...]) -> None:
    folder = package(tmp_path, "p", msg__M="int8 a\n")
    manifest(folder, *build_types)
    result = MessageDefinitions.for_model(tmp_path / "m.rscd", {}).interface("p", "M", "msg")
    assert isinstance(result, Missing) and result.reason == "faulty"
    assert "package.xml" in result.detail
