"""Fixtures of the tests that run generated packages."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from pathlib import Path

import pytest
import ros_support
from emit.golden_packages import GOLDEN, package_of
from ros1.stage import Puppet, Stage
from ros_support import EXAMPLES, Master, Workspace, built_once, run_robosc

from robosc.emit.write.writer import write

CALLED = ("orders", "missions", "dispatch")
"""Models with calls from one controller to another."""


@pytest.fixture(scope="session")
def generated_workspace(ros: None, tmp_path_factory: pytest.TempPathFactory) -> Workspace:
    """The packages of the models in ``golden/models`` and their messages, built."""
    return Workspace(built_once(tmp_path_factory, "generated", _build_generated))


def _build_generated(folder: Path) -> None:
    workspace = Workspace(folder)
    workspace.add(GOLDEN / "models" / "gauntlet_interfaces")
    workspace.add(EXAMPLES / "robot_common")
    for model in (
        "lantern",
        "gauntlet",
        "thermostat",
        "probe",
        "watch",
        "shared",
        "hoist",
        "sonar",
        "sentry",
        "courier",
        "bell",
        *CALLED,
    ):
        write(package_of(model), folder / "src")
    for model in ("gauntlet", "courier"):
        write(package_of(model, mode="monitor"), folder / "src")
    for model in ("orders", "missions", "courier", "sentry"):
        write(package_of(model, mode="supervisor"), folder / "src")
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


@pytest.fixture(scope="session")
def guarded_workspace(make_workspace: Callable[[], Workspace]) -> Workspace:
    """The line follower's supervisor and controller, and the supervisor of a lifter."""
    workspace = make_workspace()
    workspace.add(EXAMPLES / "robot_common")
    model = str(EXAMPLES / "line_follower_first_edition" / "line_follower.rscd")
    lifter = str(Path(__file__).with_name("lifter.rscd"))
    for file, mode in ((model, "supervisor"), (model, "controller"), (lifter, "supervisor")):
        where = ("--output", str(workspace.folder / "src"))
        done = run_robosc(("generate", file, "--mode", mode, *where), workspace.folder, {})
        assert done.returncode == 0, done.stderr
    workspace.build()
    return workspace


@pytest.fixture
def guarded(guarded_workspace: Workspace, shared_master: Master) -> Stage:
    return Stage(guarded_workspace, shared_master)
