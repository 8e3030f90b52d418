"""The source distribution and the wheel give the ``robosc`` command where there is no ROS."""

from __future__ import annotations

import shutil
import subprocess
from pathlib import Path

import pytest
from ros_support import EXAMPLES, REPOSITORY

from robosc import __version__
from robosc.lsp.completion.snippets import SNIPPETS
from robosc.new.skeleton import small
from robosc.view.server import PAGE

pytestmark = pytest.mark.slow

MODEL = EXAMPLES / "line_follower_first_edition" / "line_follower.rscd"


PYTHONS = {"3.11": Path("/usr/bin/python3")}
# Another one where there is one; its libraries are fetched.
for _place in (shutil.which("python3.13"), *Path.home().glob(".pyenv/versions/3.13.*/bin/python")):
    if _place is not None:
        PYTHONS["3.13"] = Path(_place)

BUILD = "import sys; from setuptools import build_meta as b; print(b.build_sdist(sys.argv[1]))"


@pytest.fixture(scope="module")
def distribution(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The source distribution."""
    folder = tmp_path_factory.mktemp("distribution")
    # It is built in the source folder, and what that leaves there would be taken for sources.
    checkout = folder / "checkout"
    shutil.copytree(
        REPOSITORY,
        checkout,
        ignore=shutil.ignore_patterns(".git", ".cache", "__pycache__", "build", "node_modules"),
    )
    done = run(PYTHONS["3.11"], "-c", BUILD, folder, cwd=checkout)
    shutil.rmtree(checkout)
    return folder / done.stdout.split()[-1]


@pytest.fixture(scope="module", params=PYTHONS)
def command(
    request: pytest.FixtureRequest, distribution: Path, tmp_path_factory: pytest.TempPathFactory
) -> Path:
    """The command, installed from the wheel that is built from the source distribution."""
    folder = tmp_path_factory.mktemp("pip")
    own = request.param == "3.11"  # nothing is fetched then: the libraries are those of Debian
    site = ("--system-site-packages",) if own else ()
    run(PYTHONS[request.param], "-m", "venv", *site, folder / "environment")
    pip = (folder / "environment" / "bin" / "pip", "--quiet", "--disable-pip-version-check")
    offline = ("--no-index", "--no-deps") if own else ()
    alone = ("--no-build-isolation",) if own else ()
    run(*pip, "wheel", *offline, *alone, "--no-deps", "--wheel-dir", folder, distribution)
    (wheel,) = folder.glob("*.whl")
    run(*pip, "install", *offline, wheel)
    return folder / "environment" / "bin" / "robosc"


def run(*words: str | Path, cwd: Path | None = None) -> subprocess.CompletedProcess[str]:
    done = subprocess.run(words, cwd=cwd, capture_output=True, text=True)
    assert done.returncode == 0, done.stdout + done.stderr
    return done


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


def test_texts_beside_the_code_are_installed(command: Path, tmp_path: Path) -> None:
    """Declarations that an editor offers, and the model of ``robosc new``."""
    program = (
        "from robosc.lsp.completion.snippets import SNIPPETS; from robosc.new.skeleton import small;"
        " print(len(SNIPPETS['robot']), small('R'))"
    )
    done = run(command.with_name("python"), "-c", program, cwd=tmp_path)
    assert done.stdout == f"{len(SNIPPETS['robot'])} {small('R')}\n"


def test_version_is_that_of_the_package() -> None:
    text = (REPOSITORY / "package.xml").read_text(encoding="utf-8")
    assert f"<version>{__version__}</version>" in text
