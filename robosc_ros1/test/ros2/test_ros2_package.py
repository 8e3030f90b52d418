"""The generated ROS 2 package as a user has it: generated, built, installed, tested, launched."""

from __future__ import annotations

import runpy
import sys
import types
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest
from catkin_pkg.package import parse_package
from ros2.ros2_support import Bed, Graph, Process

Start = Callable[..., Process]


def test_the_verb_generates_what_colcon_builds(built: Any) -> None:
    package = parse_package(str(built.folder / "src" / "guarded_arm" / "package.xml"))
    assert package.get_build_type() == "ament_python"
    needed = {dependency.name for dependency in package.exec_depends}
    assert {"rclpy", "std_msgs", "std_srvs", "robosc_testing"} <= needed
    prefix = built.folder / "install" / "guarded_arm"
    assert (prefix / "share/ament_index/resource_index/packages/guarded_arm").is_file()
    assert (prefix / "share/guarded_arm/launch/guarded_arm.launch.py").is_file()
    assert (prefix / "share/guarded_arm/config/guarded_arm.yaml").is_file()
    assert (prefix / "share/guarded_arm/package.xml").is_file()


def test_the_parameter_file_says_what_is_so_anyway(
    built: Any, graph: Graph, controller: Start
) -> None:
    file = built.folder / "src" / "guarded_arm" / "config" / "guarded_arm.yaml"
    node = controller(arguments=["--params-file", file])
    robot = graph.peer()
    robot.watch("guarded_arm")
    robot.expect_state("guarded_arm", lambda s: s["counters"]["commands"] > 0)
    node.end()
    assert node.popen.returncode == 0
    assert "unknown parameter" not in node.output


def test_the_package_s_own_test_plays_the_robot(built: Any, graph: Graph) -> None:
    test = graph.start(
        graph.bed.python, "-m", "pytest", "-q", "-s", "-p", "no:cacheprovider",
        built.folder / "src" / "guarded_arm" / "test",
        **built.environment("guarded_arm"), ROBOSC_SECONDS="4",
    )  # fmt: skip
    code = test.wait(120)
    assert code == 0, test.output
    assert "1 passed" in test.output


def test_colcon_runs_the_package_s_own_test(bed: Bed, built: Any) -> None:
    command = (
        "colcon",
        "test",
        "--packages-select",
        "guarded_arm",
        "--return-code-on-test-failure",
    )
    output = bed.run(*command, "--pytest-args", "--collect-only", folder=built.folder)
    assert "1 package finished" in output
    log = built.folder / "log" / "latest_test" / "guarded_arm" / "stdout.log"
    assert "test_every_command_is_allowed" in log.read_text()


class Recorder:
    """Stands for a class of launch, of which there are no wheels: keeps what it was made with."""

    def __init__(self, *given: Any, **named: Any) -> None:
        self.given = given
        self.named = named


@pytest.fixture
def launch(monkeypatch: pytest.MonkeyPatch, built: Any) -> Callable[..., dict[str, Any]]:
    """Runs the launch file with arguments; what the node is started with."""

    class Configuration:
        def __init__(self, name: str) -> None:
            self.name = name

        def perform(self, context: dict[str, str]) -> str:
            return context[self.name]

    parts = {
        "ament_index_python.packages": {
            "get_package_share_directory": lambda name: f"/share/{name}"
        },
        "launch": {"LaunchDescription": Recorder},
        "launch.actions": {"DeclareLaunchArgument": Recorder, "OpaqueFunction": Recorder},
        "launch.substitutions": {"LaunchConfiguration": Configuration},
        "launch_ros.actions": {"Node": Recorder},
    }
    for name, content in parts.items():
        module = types.ModuleType(name)
        module.__dict__.update(content)
        monkeypatch.setitem(sys.modules, name, module)
    file: Path = built.folder / "src" / "guarded_arm" / "launch" / "guarded_arm.launch.py"

    def run(**arguments: str) -> dict[str, Any]:
        description = runpy.run_path(str(file))["generate_launch_description"]()
        *declared, action = description.given[0]
        values = {d.given[0]: d.named["default_value"] for d in declared}
        assert set(arguments) <= set(values)
        (node,) = action.named["function"](values | arguments)
        named: dict[str, Any] = node.named
        return named

    return run


def test_the_launch_file_starts_the_node(launch: Callable[..., dict[str, Any]]) -> None:
    node = launch()
    assert (node["package"], node["executable"]) == ("guarded_arm", "guarded_arm")
    assert (node["name"], node["namespace"], node["respawn"]) == ("guarded_arm", "", False)
    assert node["parameters"] == ["/share/guarded_arm/config/guarded_arm.yaml", {}]


def test_the_launch_file_takes_parameters_as_arguments(
    launch: Callable[..., dict[str, Any]],
) -> None:
    node = launch(ns="left", rate="5", timeout_lock="0.5", stop_command="warn", respawn="true")
    assert (node["namespace"], node["respawn"]) == ("left", True)
    assert node["parameters"][1] == {"rate": 5, "timeout.lock": 0.5, "stop_command": "warn"}
    node = launch(remap="beacon=/lamp ~state=told")
    assert node["remappings"] == [("beacon", "/lamp"), ("~/state", "told")]
