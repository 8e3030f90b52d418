"""The generated ROS 2 package as a user has it: generated, built, installed, tested, launched."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest
from catkin_pkg.package import parse_package
from ros2.bed import Bed
from ros2.launching import Node, given_to, started
from ros2.ros2_support import Graph, Process
from ros_support import run_robosc

Start = Callable[..., Process]


def test_the_verb_generates_what_colcon_builds(built: Any) -> None:
    package = parse_package(str(built.folder / "src" / "guarded_arm" / "package.xml"))
    assert package.package_format == 3
    assert package.get_build_type() == "ament_python"
    needed = {dependency.name for dependency in package.exec_depends}
    assert {"rclpy", "std_msgs", "std_srvs", "robosc_testing"} <= needed
    prefix = built.folder / "install" / "guarded_arm"
    assert (prefix / "share/ament_index/resource_index/packages/guarded_arm").is_file()
    assert (prefix / "share/guarded_arm/launch/guarded_arm.launch.py").is_file()
    assert (prefix / "share/guarded_arm/config/guarded_arm.yaml").is_file()
    assert (prefix / "share/guarded_arm/package.xml").is_file()


def test_a_topic_of_two_types_is_refused(tmp_path: Path) -> None:
    """The middleware would not start such a node, and not say why."""
    (tmp_path / "two.rscd").write_text(
        "robot Two { component A {\n"
        'outgoing message a with identifier: "/t", type: boolean\n'
        'incoming message b with identifier: "/t", type: string\n'
        "} }\n"
    )
    done = run_robosc(("generate", "two.rscd", "--target", "ros2"), tmp_path, {})
    assert done.returncode == 2
    assert (
        "two.rscd:3: the topic /t carries std_msgs/msg/String here and std_msgs/msg/Bool in line 2;"
        in done.stderr
    )


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


@pytest.mark.once
@pytest.mark.parametrize("package", ["guarded_arm", "shared_controller", "crane_monitor"])
def test_the_package_s_own_test_plays_the_robot(built: Any, graph: Graph, package: str) -> None:
    test = graph.start(
        graph.bed.python, "-m", "pytest", "-q", "-s", "-p", "no:cacheprovider",
        built.folder / "src" / package / "test",
        **built.environment(package),
    )  # fmt: skip
    code = test.wait(240.0)
    assert code == 0, test.output


def test_own_tests_of_one_robot_that_run_at_once_wait_for_each_other(
    built: Any, graph: Graph
) -> None:
    tests = [
        graph.start(
            graph.bed.python, "-m", "pytest", "-q", "-s", "-p", "no:cacheprovider",
            built.folder / "src" / package / "test",
            **built.environment(package),
        )
        for package in ("crane_supervisor", "crane_monitor")
    ]  # fmt: skip
    for test in tests:
        assert test.wait(240.0) == 0, test.output


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
    assert "test_script[run_1]" in log.read_text()
    assert "test_commands_are_shown" in log.read_text()


@pytest.fixture
def launch(built: Any) -> Callable[..., Node]:
    """What the launch file starts with some arguments."""
    file: Path = built.folder / "src" / "guarded_arm" / "launch" / "guarded_arm.launch.py"

    def run(**arguments: str) -> Node:
        (node,) = started(file, lambda package: f"/share/{package}", **arguments)
        return node

    return run


@pytest.mark.once
def test_the_launch_file_starts_the_node(launch: Callable[..., Node]) -> None:
    node = launch()
    assert (node.package, node.executable) == ("guarded_arm", "guarded_arm")
    assert (node.name, node.namespace, node.respawn) == ("guarded_arm", "", False)
    assert node.parameters == ["/share/guarded_arm/config/guarded_arm.yaml"]


def test_the_launch_file_takes_parameters_as_arguments(
    launch: Callable[..., Node],
) -> None:
    node = launch(ns="left", rate="5", event_log="on", near_by="2e-3")
    given = {"rate": 5, "event_log": "on", "near_by": 0.002}
    assert given_to(node, "/left/guarded_arm") == given
    assert given_to(launch(ns="/a/b", rate="5"), "/a/b/guarded_arm") == {"rate": 5}
    node = launch(ns="left", respawn="true")
    assert (node.namespace, node.respawn) == ("left", True)
    for text in (
        "beacon=/lamp ~state=told",
        "beacon:=/lamp ~state:=told",
        " beacon:=/lamp  ~/state=told",
    ):
        node = launch(remap=text)
        assert node.remappings == [("beacon", "/lamp"), ("~/state", "told")]


@pytest.mark.parametrize("word", ["beacon", "beacon=", ":=/lamp", "beacon:/lamp"])
def test_the_launch_file_refuses_what_is_no_pair_of_names(
    launch: Callable[..., Node], word: str
) -> None:
    with pytest.raises(ValueError, match=f"remap: '{word}' must be two names, like /old=/new"):
        launch(remap="go=/want " + word)


@pytest.fixture
def thermostat(built: Any, graph: Graph, tmp_path: Path) -> Callable[..., Process]:
    """Starts a node that has parameters of every type, by its launch file."""
    package = "thermostat_controller"
    prefix = built.folder / "install" / package

    def start(*more: str, **arguments: str) -> Process:
        file = prefix / "share" / package / "launch" / f"{package}.launch.py"
        (node,) = started(file, lambda _: str(prefix / "share" / package), **arguments)
        command = node.command(built.folder / "install", tmp_path)
        command[0] = str(built.executable(package))
        return graph.start(*command, *more, **built.environment(package))

    return start


def test_parameters_of_every_type_at_launch(
    thermostat: Callable[..., Process], graph: Graph
) -> None:
    node = thermostat(
        wanted="18", steps="3", limit="-9223372036854775808", season="summer", greeting="y",
        Heater_eager="true", Heater_pause="2.5",
    )  # fmt: skip
    robot = graph.peer()
    robot.watch("thermostat_controller")
    state = robot.expect_state("thermostat_controller", lambda s: True)
    assert state["parameters"] == {
        "wanted": 18.0, "steps": 3, "limit": -(2**63), "season": "summer", "greeting": "y",
        "Heater/eager": True, "Heater/pause": 2.5, "Sensor/silence": 5.0,
    }  # fmt: skip
    assert "unknown parameter" not in node.output


@pytest.mark.once
def test_values_are_published_for_tools_that_plot(
    thermostat: Callable[..., Process], graph: Graph
) -> None:
    robot = graph.peer()
    values = "thermostat_controller/values"
    robot.subscribe(f"{values}/Sensor/degrees", "std_msgs/msg/Float64")
    robot.subscribe(f"{values}/Heater", "std_msgs/msg/Int32")
    thermostat(publish_values="true")
    robot.expect("message", name=f"{values}/Sensor/degrees", where=lambda m: m["data"] == 15.0)
    robot.expect("message", name=f"{values}/Heater", where=lambda m: m["data"] == 0)


@pytest.mark.parametrize(
    ("more", "arguments", "complaints"),
    [
        (
            "greeting:=5",
            {"wanted": "warm", "steps": "2.0", "limit": "ninety", "Heater_eager": "1"},
            (
                "parameter wanted must be a number, not 'warm'",
                "parameter steps must be an integer, not 2.0",
                "parameter limit must be an integer, not 'ninety'",
                "parameter Heater.eager must be true or false, not 1",
                "parameter greeting must be a string (in quotes), not 5",
            ),
        ),
        (
            "wanted:=.nan",
            {"steps": "4", "season": "spring", "Heater_pause": "0"},
            (
                "parameter wanted must be a number, not nan",
                "parameter steps must be an integer of at most 3, not 4",
                "parameter season must be one of winter, summer, not 'spring'",
                "parameter Heater.pause must be a number of at least 0.001, not 0",
            ),
        ),
    ],
)
def test_parameters_at_launch_are_refused_by_name(
    thermostat: Callable[..., Process],
    more: str,
    arguments: dict[str, str],
    complaints: tuple[str, ...],
) -> None:
    node = thermostat("-p", more, **arguments)
    assert node.wait() == 2
    for complaint in complaints:
        assert complaint in node.output
    assert "Traceback" not in node.output


def parameter_file(folder: Path, text: str) -> str:
    file = folder / "given.yaml"
    file.write_text(f"/**:\n  ros__parameters: {text}\n", encoding="utf-8")
    return str(file)


def test_empty_lists_of_others_are_no_fault(
    thermostat: Callable[..., Process], graph: Graph, tmp_path: Path
) -> None:
    file = parameter_file(tmp_path, "{footprint: [], local_costmap: {plugins: []}, wanted: 18.0}")
    node = thermostat("--params-file", file)
    robot = graph.peer()
    robot.watch("thermostat_controller")
    state = robot.expect_state("thermostat_controller", lambda s: True)
    assert state["parameters"]["wanted"] == 18.0
    assert "unknown parameter footprint is ignored" in node.output


@pytest.mark.parametrize(
    ("text", "told"),
    [
        ("{rate: []}", "parameter rate must be a number, not []"),
        ("{use_sim_time: []}", "parameter use_sim_time must be true or false, not []"),
    ],
)
def test_an_empty_list_for_a_parameter_of_the_node_is_one_line(
    controller: Callable[..., Process], tmp_path: Path, text: str, told: str
) -> None:
    node = controller(arguments=("--params-file", parameter_file(tmp_path, text)))
    assert node.wait() == 2
    assert told in node.output
    assert "Traceback" not in node.output


@pytest.mark.parametrize(
    ("words", "told"),
    [
        (("-p", "wanted:={a: 1"), "wanted:={a: 1"),
        (("-p", "wanted"), "wanted"),
        (("--params-file", "/nowhere.yaml"), "/nowhere.yaml"),
        (("-r", "__node:=9 9"), "__node:=9 9"),
        (("--bogus",), "--bogus"),
    ],
)
def test_arguments_that_ros_cannot_read(
    controller: Start, words: tuple[str, ...], told: str
) -> None:
    node = controller(arguments=words)
    assert node.wait() == 2
    (line,) = [one for one in node.output.splitlines() if one.startswith("ROS 2 cannot start")]
    assert told in line
    assert "Traceback" not in node.output
