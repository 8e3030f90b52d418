"""The repository is an ament_python package: colcon builds it, and ``ros2 run`` finds its verbs."""

from __future__ import annotations

import subprocess
from pathlib import Path

import pytest
from ros2.bed import REPOSITORY, Bed
from ros_support import EXAMPLES, PYTHON, link_checkout

MODEL = EXAMPLES / "line_follower_first_edition" / "line_follower.rscd"


@pytest.fixture(scope="module", params=["", "--symlink-install"])
def prefix(
    request: pytest.FixtureRequest, bed: Bed, tmp_path_factory: pytest.TempPathFactory
) -> Path:
    """Where colcon has installed the package, by copies or by links."""
    folder = tmp_path_factory.mktemp("colcon")
    link_checkout(folder / "src" / "robosc")
    colcon = [bed.python, "-m", "colcon", "build", *filter(None, [request.param])]
    bed.run("env", "ROS_VERSION=2", *colcon, folder=folder)
    return folder / "install" / "robosc"


def start(prefix: Path, verb: str, *arguments: str | Path, folder: Path) -> str:
    """The output of what ``ros2 run robosc VERB`` starts, in the environment of setup.bash.

    The bed has colcon, not the libraries of robosc, so Debian's Python takes the place of its own.
    """
    setup = prefix.parent / "setup.bash"
    command = '. "$0" && shift 0 && exec "$@"'
    done = subprocess.run(
        ["bash", "-c", command, setup, PYTHON, prefix / "lib" / "robosc" / verb, *arguments],
        cwd=folder, capture_output=True, text=True,
        env={"PATH": "/usr/bin:/bin", "ROS_VERSION": "2"},
    )  # fmt: skip
    assert done.returncode == 0, done.stderr
    return done.stdout


def test_ros2_knows_the_package(prefix: Path) -> None:
    assert (prefix / "share/ament_index/resource_index/packages/robosc").is_file()
    assert (prefix / "share/robosc/package.xml").is_file()
    scripts = REPOSITORY / "robosc_ros1" / "scripts"
    found = {file.name for file in (prefix / "lib" / "robosc").iterdir()}
    assert found == {file.name for file in scripts.iterdir()}


def test_generate_is_for_the_ros_that_is_sourced(prefix: Path, tmp_path: Path) -> None:
    told = start(prefix, "generate", MODEL, folder=tmp_path)
    assert "for ROS 2 (ROS_VERSION is 2)" in told
    assert (tmp_path / "line_follower_controller" / "setup.cfg").is_file()


def test_the_symbolic_engine_is_found_after_dev_setup(prefix: Path, tmp_path: Path) -> None:
    pytest.importorskip("oxidd")
    told = start(prefix, "synthesize", "--engine", "bdd", MODEL, folder=tmp_path)
    assert "bdd engine" in told.splitlines()[0]
