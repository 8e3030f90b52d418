"""``pip install .`` gives the ``robosc`` command where there is no ROS."""

from __future__ import annotations

import shutil
import subprocess
import venv
from pathlib import Path

import pytest
from ros_support import EXAMPLES, REPOSITORY

from robosc import __version__
from robosc.view.server import PAGE

pytestmark = pytest.mark.slow

MODEL = EXAMPLES / "line_follower" / "line_follower.rscd"


@pytest.fixture(scope="module")
def command(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The installed command. Nothing is fetched: the libraries are those of this Python."""
    pytest.importorskip("ensurepip", reason="this Python has no venv")
    pytest.importorskip("wheel", reason="building without a network needs wheel")
    folder = tmp_path_factory.mktemp("pip")
    # pip builds in the source folder, and what it leaves there would be taken for sources.
    checkout = folder / "checkout"
    shutil.copytree(
        REPOSITORY,
        checkout,
        ignore=shutil.ignore_patterns(".git", ".cache", "__pycache__", "build"),
    )
    environment = folder / "environment"
    venv.create(environment, system_site_packages=True, with_pip=True)
    pip = [environment / "bin" / "pip", "install", "--quiet", "--no-index"]
    done = subprocess.run(
        [*pip, "--no-build-isolation", "--no-deps", checkout], capture_output=True, text=True
    )
    assert done.returncode == 0, done.stderr
    shutil.rmtree(checkout)
    return environment / "bin" / "robosc"


def test_check(command: Path, tmp_path: Path) -> None:
    done = subprocess.run(
        [command, "check", MODEL], cwd=tmp_path, capture_output=True, text=True, env={}
    )
    assert (done.returncode, done.stderr) == (0, "") or "robot_common" in done.stderr
    assert done.stdout.startswith("1 file: 0 errors")


def test_generate_finds_its_templates(command: Path, tmp_path: Path) -> None:
    done = subprocess.run(
        [command, "generate", MODEL], cwd=tmp_path, capture_output=True, text=True, env={}
    )
    assert done.returncode == 0, done.stderr
    assert (tmp_path / "line_follower_controller" / "package.xml").is_file()


def test_the_page_of_view_is_installed(command: Path, tmp_path: Path) -> None:
    program = "from robosc.view.server import PAGE; print(*sorted(p.name for p in PAGE.iterdir()))"
    done = subprocess.run(
        [command.with_name("python"), "-c", program],
        cwd=tmp_path, capture_output=True, text=True, env={},
    )  # fmt: skip
    assert done.stdout.split() == sorted(file.name for file in PAGE.iterdir())


def test_version_is_that_of_the_package() -> None:
    text = (REPOSITORY / "package.xml").read_text(encoding="utf-8")
    assert f"<version>{__version__}</version>" in text
