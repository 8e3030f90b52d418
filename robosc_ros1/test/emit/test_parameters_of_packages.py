"""Every parameter of a node: in its launch file, its parameter file and its README, on both ROS."""

from __future__ import annotations

import re
from pathlib import Path
from typing import Any
from xml.etree import ElementTree

import pytest
from emit.golden_packages import model_path
from hypothesis import given
from hypothesis import strategies as st
from ros2.launching import given_to, started

from robosc import pipeline
from robosc.emit.package import ros1_target, ros2_target
from robosc.emit.package.config import Config, declared_communications
from robosc.emit.package.package import Package
from robosc.emit.package.readme import yaml_text
from robosc.emit.write.writer import write
from robosc.runtime.core import settings
from robosc.runtime.core.qos import qos_parameters
from robosc.supervisor import Supervisor

EMITTERS = {"ros1": ros1_target.emit, "ros2": ros2_target.emit}
PACKAGE = "some_controller"
CHANGED = {
    "state_rate": 1e22, "stop_command": "shout", "event_log": 'C:\\logs\n"new" | ~/ä.log', "seed": -3,
    "goal_timeout/reach": 12.5, "exit_on_stop": True,
}  # fmt: skip


@pytest.fixture(scope="module")
def gauntlet() -> Supervisor:
    """Messages, a service, an action, and two imports of one component."""
    return pipeline.synthesize(pipeline.load(model_path("gauntlet")).robot)


def declared_by(supervisor: Supervisor, target: str) -> dict[str, settings.Parameter]:
    communications = declared_communications(supervisor.plant.robot)
    more = qos_parameters(communications) if target == "ros2" else []
    if target == "ros2":  # one for each topic
        more = [p for p in more if p.name.rpartition("/")[0] in topics_of(supervisor)]
    found = {p.name: p for p in settings.declared(communications) + more}
    del found["shadow"]  # of monitors
    return {named(name, target): parameter for name, parameter in found.items()}


def named(name: str, target: str) -> str:
    """ROS 1 has ``rate`` in the group with the rates of commands."""
    return settings.GENERAL_RATE if (name, target) == ("rate", "ros1") else name


def topics_of(supervisor: Supervisor) -> set[str]:
    seen: dict[tuple[str, Any], str] = {}
    robot = supervisor.plant.robot
    for key, message in robot.communications.items():
        name = "qos/" + settings.parameter_name(robot.display_names[key])
        seen.setdefault((message.identifier, message.kind), name)
    return set(seen.values())


def written(package: Package, target: str) -> dict[str, Any]:
    """What the parameter file says, by the names of ROS 1."""
    yaml = pytest.importorskip("yaml")
    document = yaml.safe_load(package.files[f"config/{PACKAGE}.yaml"].content)
    if target == "ros2":
        document = {k.replace(".", "/"): v for k, v in document["/**"]["ros__parameters"].items()}
    return settings.flatten(document)


@pytest.mark.parametrize("target", EMITTERS)
@pytest.mark.parametrize("changed", [{}, CHANGED])
def test_the_parameter_file_has_every_default(
    gauntlet: Supervisor, target: str, changed: dict[str, Any]
) -> None:
    found = written(EMITTERS[target](gauntlet, PACKAGE, Config(parameters=changed)), target)
    expected = {name: p.default for name, p in declared_by(gauntlet, target).items()}
    assert found == {**expected, **{named(name, target): v for name, v in changed.items()}}


@pytest.mark.parametrize("target", EMITTERS)
def test_the_readme_documents_every_parameter(gauntlet: Supervisor, target: str) -> None:
    readme = EMITTERS[target](gauntlet, PACKAGE).files["README.md"].content
    rows = dict(re.findall(r"^\| `([^`]+)` \| (\w+ \| `[^`]*` \| .+) \|$", readme, re.MULTILINE))
    for name, parameter in declared_by(gauntlet, target).items():
        type_, default, meaning = rows[name.replace("/", "." if target == "ros2" else "/")].split(
            " | ", 2
        )
        assert type_ == parameter.type
        assert default.strip("`") in (repr(parameter.default).lower(), f'"{parameter.default}"')
        assert meaning.startswith(parameter.meaning)
        assert all(choice in meaning for choice in parameter.choices)
        if parameter.maximum is not None:
            assert f"({parameter.minimum} to {parameter.maximum})" in meaning
        elif parameter.minimum is not None:
            assert f"at least {parameter.minimum:g}" in meaning


AT_LAUNCH = {
    "rate",
    "stop_command",
    "event_log",
    "publish_values",
    "operate",
    "tolerance",
}


def test_the_launch_file_takes_what_differs_between_launches() -> None:
    thermostat = pipeline.synthesize(pipeline.load(model_path("thermostat")).robot)
    of_model = {p.name for p in thermostat.plant.robot.parameters}
    launch = EMITTERS["ros1"](thermostat, PACKAGE).files[f"launch/{PACKAGE}.launch"].content
    root = ElementTree.fromstring(launch)
    arguments = {arg.attrib["name"]: arg.attrib["default"] for arg in root.findall("arg")}
    (node,) = root.findall("node")
    given = {param.attrib["name"]: param.attrib for param in node.findall("param")}
    assert set(given) == {named(name, "ros1") for name in AT_LAUNCH} | of_model
    for name, attributes in given.items():
        argument = name.removesuffix("/default").replace("/", "_")
        assert attributes["value"] == f"$(arg {argument})"
        assert arguments[argument] == ""


def test_the_launch_file_of_ros_2_takes_what_differs_between_launches(
    gauntlet: Supervisor, tmp_path: Path
) -> None:
    pytest.importorskip("yaml")
    write(EMITTERS["ros2"](gauntlet, PACKAGE), tmp_path)
    launch = tmp_path / PACKAGE / "launch" / f"{PACKAGE}.launch.py"
    names = AT_LAUNCH | {"use_sim_time"}
    (node,) = started(launch, str, **dict.fromkeys(names, "7"))
    assert set(given_to(node, f"/{PACKAGE}")) == names
    with pytest.raises(AssertionError):
        started(launch, str, server_lost_after="7")
    (node,) = started(launch, str)
    assert given_to(node, f"/{PACKAGE}") == {}


def test_the_launch_file_of_ros_2_takes_parameters_of_components(tmp_path: Path) -> None:
    pytest.importorskip("yaml")
    thermostat = pipeline.synthesize(pipeline.load(model_path("thermostat")).robot)
    write(EMITTERS["ros2"](thermostat, PACKAGE), tmp_path)
    launch = tmp_path / PACKAGE / "launch" / f"{PACKAGE}.launch.py"
    (node,) = started(launch, str, Heater_pause="0.5", wanted="18.0")
    assert given_to(node, f"/{PACKAGE}") == {"Heater.pause": 0.5, "wanted": 18.0}


VALUES = st.recursive(
    st.booleans() | st.integers() | st.floats(allow_nan=False, allow_infinity=False),
    lambda parts: st.lists(parts) | st.dictionaries(st.sampled_from(["x", "y"]), parts),
)


@given(VALUES)
def test_a_value_in_a_parameter_file_is_read_as_what_it_is(value: Any) -> None:
    """To PyYAML, with which ROS 1 reads it, 1e-05 is a text."""
    yaml = pytest.importorskip("yaml")
    found = yaml.safe_load(yaml_text(value))
    assert repr(found) == repr(value)


ROBOT = """\
robot Twins {
    parameter A_wide: double = 1.0
    parameter config: double = 1.0
    component A {
        parameter wide: double = 1.0
        incoming message go with identifier: "/go", type: double
    }
    provide go with A_wide + A.wide + config
    stop with go
}
"""


def test_arguments_have_names_of_their_own(tmp_path: Path) -> None:
    (tmp_path / "twins.rscd").write_text(ROBOT)
    supervisor = pipeline.synthesize(pipeline.load(tmp_path / "twins.rscd").robot)
    launch = EMITTERS["ros1"](supervisor, PACKAGE).files[f"launch/{PACKAGE}.launch"].content
    names = re.findall(r'<arg name="([^"]+)" default', launch)
    assert {name for name in names if name.startswith("A_wide")} == {"A_wide", "A_wide_"}
    assert {name for name in names if name.startswith("config")} == {"config", "config_"}
    assert len(names) == len(set(names))
