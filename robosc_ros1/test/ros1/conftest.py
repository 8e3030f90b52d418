"""Fixtures of the tests that run generated packages."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from pathlib import Path

import pytest
import reflecting
import ros_support
from agents.agent_support import sdk, start_agent
from agents.tried import LIBRARIES, LIMITER
from emit.golden_packages import GOLDEN, package_of
from primitives import PRIMITIVES_OF_ROS1
from ros1.stage import Node, Puppet, Stage
from ros_support import EXAMPLES, Master, Workspace, built_once, run_robosc

from robosc.emit.write.writer import write

__all__ = ["sdk", "start_agent"]

TESTED = (
    "lantern_controller", "gauntlet_controller", "thermostat_controller", "hoist_controller",
    "sonar_controller", "courier_controller", "sentry_controller", "shared_controller",
    "probe_controller", "missions_controller", "courier_supervisor", "courier_monitor",
    "sentry_supervisor", "lantern_monitor", "hoist_monitor", "orders_supervisor",
    "missions_supervisor", "gauntlet_monitor",
)  # fmt: skip
"""Packages of which somebody runs their own tests."""
UNTESTED = ("watch_controller", "bell_controller", "orders_controller", "dispatch_controller")

INTERFACES = {
    "CMakeLists.txt": """
cmake_minimum_required(VERSION 3.10)
project(robosc_testing)
find_package(catkin REQUIRED COMPONENTS actionlib_msgs message_generation std_msgs)
add_message_files(FILES Primitives.msg)
add_service_files(FILES Reflect.srv)
add_action_files(FILES Shine.action)
generate_messages(DEPENDENCIES actionlib_msgs std_msgs)
catkin_package(CATKIN_DEPENDS actionlib_msgs message_runtime std_msgs)
""",
    "package.xml": """<?xml version="1.0"?>
<package format="3">
  <name>robosc_testing</name>
  <version>0.1.0</version>
  <description>Interfaces for tests.</description>
  <maintainer email="robosc@example.org">robosc contributors</maintainer>
  <license>BSD-3-Clause</license>
  <buildtool_depend>catkin</buildtool_depend>
  <build_depend>message_generation</build_depend>
  <depend>actionlib_msgs</depend>
  <depend>std_msgs</depend>
  <exec_depend>message_runtime</exec_depend>
</package>
""",
    **reflecting.files(PRIMITIVES_OF_ROS1),
}


@pytest.fixture(scope="session")
def generated_workspace(ros: None, tmp_path_factory: pytest.TempPathFactory) -> Workspace:
    """The packages of the models in ``golden/models`` and their messages, built."""
    return Workspace(built_once(tmp_path_factory, "generated", _build_generated))


def _build_generated(folder: Path) -> None:
    workspace = Workspace(folder)
    workspace.add(GOLDEN / "models" / "gauntlet_interfaces")
    workspace.add(EXAMPLES / "robot_common")
    for name in (*TESTED, *UNTESTED):
        model, _, mode = name.rpartition("_")
        write(package_of(model, mode=mode, tested=name in TESTED), folder / "src")
    for place, text in INTERFACES.items():
        file = folder / "src" / "robosc_testing" / place
        file.parent.mkdir(parents=True, exist_ok=True)
        file.write_text(text, encoding="utf-8")
    model_file = folder / "reflector.rscd"
    model_file.write_text(reflecting.model(PRIMITIVES_OF_ROS1), encoding="utf-8")
    for file, mode in (
        (GOLDEN / "models" / "fleet.rscd", "controller"),
        (Path(__file__).with_name("examiner.rscd"), "controller"),
        (Path(__file__).with_name("trolley.rscd"), "monitor"),
        (model_file, "controller"),
        (model_file, "supervisor"),
    ):
        where = ("--mode", mode, "--output", str(folder / "src"))
        known = {"ROS_PACKAGE_PATH": str(folder / "src")}
        done = run_robosc(("generate", str(file), *where), folder, known, tested=False)
        assert done.returncode == 0, done.stderr
    workspace.build()


@pytest.fixture(scope="module")
def shared_master(ros: None, tmp_path_factory: pytest.TempPathFactory) -> Iterator[Master]:
    """One master for the tests of a module; each test ends the nodes that it starts."""
    with ros_support.master(tmp_path_factory.mktemp("master")) as running:
        yield running


@pytest.fixture
def stage(generated_workspace: Workspace, shared_master: Master) -> Stage:
    return Stage(generated_workspace, shared_master)


@pytest.fixture
def puppet(stage: Stage) -> Iterator[Puppet]:
    with stage.puppet() as running:
        yield running


@pytest.fixture
def ear(stage: Stage) -> Iterator[Puppet]:
    """A second puppet, that only listens, so that the first may be killed."""
    with stage.puppet() as running:
        yield running


@pytest.fixture(params=["controller", "supervisor"])
def nodes(
    request: pytest.FixtureRequest, stage: Stage, ear: Puppet, model: str
) -> Iterator[tuple[Node, ...]]:
    """The controller of a model that is called; once more with its supervisor, which comes first."""
    if request.param == "supervisor":
        with stage.guarded(ear, model) as both:
            yield both
    else:
        with stage.controller(ear, f"{model}_controller") as node:
            yield (node,)


@pytest.fixture(scope="session")
def guarded_workspace(make_workspace: Callable[[], Workspace]) -> Workspace:
    """The line follower's supervisor and controller, and supervisors of a lifter and a limiter."""
    workspace = make_workspace()
    workspace.add(EXAMPLES / "robot_common")
    model = str(EXAMPLES / "line_follower_first_edition" / "line_follower.rscd")
    lifter = str(Path(__file__).with_name("lifter.rscd"))
    limiter = str(LIMITER)
    for file, mode in (
        (model, "supervisor"),
        (model, "controller"),
        (lifter, "supervisor"),
        (limiter, "supervisor"),
    ):
        libraries = ("--library-path", str(LIBRARIES)) if file == limiter else ()
        where = (*libraries, "--output", str(workspace.folder / "src"))
        words = ("generate", file, "--mode", mode, *where)
        done = run_robosc(words, workspace.folder, {}, tested=(file, mode) == (model, "supervisor"))
        assert done.returncode == 0, done.stderr
    workspace.build()
    return workspace


@pytest.fixture(scope="session")
def crane_workspace(make_workspace: Callable[[], Workspace]) -> Workspace:
    """The supervisor of a crane, which corrects messages, calls and goals."""
    workspace = make_workspace()
    workspace.add(GOLDEN / "models" / "gauntlet_interfaces")
    model = str(Path(__file__).with_name("crane.rscd"))
    where = ("--output", str(workspace.folder / "src"))
    words = ("generate", model, "--mode", "supervisor", *where)
    done = run_robosc(words, workspace.folder, {}, tested=False)
    assert done.returncode == 0, done.stderr
    workspace.build()
    return workspace


@pytest.fixture
def crane(crane_workspace: Workspace, shared_master: Master) -> Stage:
    return Stage(crane_workspace, shared_master)


@pytest.fixture
def guarded(guarded_workspace: Workspace, shared_master: Master) -> Stage:
    return Stage(guarded_workspace, shared_master)
