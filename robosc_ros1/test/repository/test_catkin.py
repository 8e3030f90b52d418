"""The repository is a catkin package: devel and install space, with ``rosrun`` in both."""

from __future__ import annotations

import json
import os
from collections.abc import Callable, Iterator
from pathlib import Path

import pytest
from ros_support import EXAMPLES, PYTHON, REPOSITORY, Workspace

from robosc import executables
from robosc.lsp.completion.snippets import SNIPPETS
from robosc.new.skeleton import small
from robosc.view.server import PAGE

MODEL = EXAMPLES / "line_follower" / "line_follower.rscd"
SCRIPTS = REPOSITORY / "robosc_ros1" / "scripts"
VERBS = sorted(p.name for p in SCRIPTS.iterdir())
"""``robosc`` itself, which takes a verb, included."""


@pytest.fixture(scope="module")
def installed(make_workspace: Callable[[], Workspace]) -> Workspace:
    """The repository alone, in devel and install space."""
    workspace = make_workspace()
    workspace.add_robosc()
    workspace.build("install")
    return workspace


@pytest.fixture(params=["devel", "install"])
def space(request: pytest.FixtureRequest) -> str:
    name: str = request.param
    return name


def test_check(installed: Workspace, space: str) -> None:
    done = installed.run("rosrun", "robosc", "check", "--json", str(MODEL), space=space)
    assert json.loads(done.stdout)["version"] == 1
    assert done.stderr == ""


def test_generate_writes_the_same_package_as_the_checkout(
    installed: Workspace, space: str, tmp_path: Path, robosc: Callable[..., object]
) -> None:
    installed.run(
        "rosrun", "robosc", "generate", str(MODEL), "--output", str(tmp_path / space), space=space
    )
    robosc("generate", str(MODEL), "--output", str(tmp_path / "checkout"))
    assert contents(tmp_path / space) == contents(tmp_path / "checkout")


def contents(folder: Path) -> dict[str, bytes]:
    found = {p.relative_to(folder).as_posix(): p.read_bytes() for p in files(folder)}
    assert found
    return found


def files(folder: Path) -> Iterator[Path]:
    return (p for p in folder.rglob("*") if p.is_file() and "__pycache__" not in p.parts)


def test_ros2_run_has_what_rosrun_has() -> None:
    assert all(callable(getattr(executables, verb)) for verb in VERBS)


@pytest.mark.parametrize("verb", VERBS)
def test_every_verb_is_found_and_only_once(installed: Workspace, space: str, verb: str) -> None:
    """rosrun would ask which of several is meant."""
    done = installed.run("rosrun", "robosc", verb, "--help", space=space)
    assert done.stdout.startswith("usage: robosc")


def test_the_door_of_the_readme_runs_on_the_python_of_ros(installed: Workspace) -> None:
    """Whichever python3 is first on PATH where rosrun is called."""
    done = installed.run("rosrun", "--prefix", "head -n1", "robosc", "simulated_door")
    assert done.stdout == f"#!{PYTHON}\n"


def test_install_space_needs_no_checkout(installed: Workspace) -> None:
    """Nothing in the install space leads back to the sources."""
    paths = list(files(installed.folder / "install"))
    assert any(p.suffix == ".jinja" for p in paths)
    for path in paths:
        assert str(REPOSITORY).encode() not in path.read_bytes(), path
    probe = "import robosc.cli; print(robosc.cli.__file__)"
    done = installed.run("/usr/bin/python3", "-c", probe, space="install")
    assert done.stdout.startswith(str(installed.folder / "install"))


def test_the_symbolic_engine_is_found_after_dev_setup(installed: Workspace, space: str) -> None:
    pytest.importorskip("oxidd")
    done = installed.run(
        "rosrun", "robosc", "synthesize", "--engine", "bdd", str(MODEL), space=space
    )
    assert "bdd engine" in done.stdout.splitlines()[0]


def test_the_page_of_view_is_found(installed: Workspace, space: str) -> None:
    program = "from robosc.view.server import PAGE; print(*sorted(p.name for p in PAGE.iterdir()))"
    done = installed.run("/usr/bin/python3", "-c", program, space=space)
    assert done.stdout.split() == sorted(file.name for file in PAGE.iterdir())


def test_texts_beside_the_code_are_found(installed: Workspace, space: str) -> None:
    program = (
        "from robosc.lsp.completion.snippets import SNIPPETS; from robosc.new.skeleton import small;"
        " print(len(SNIPPETS['robot']), small('R'))"
    )
    done = installed.run("/usr/bin/python3", "-c", program, space=space)
    assert done.stdout == f"{len(SNIPPETS['robot'])} {small('R')}\n"


def test_message_definitions_of_the_workspace_are_found(
    example_workspace: Workspace, tmp_path: Path
) -> None:
    """A model that sends a field that the service's request lacks is wrong."""
    model = tmp_path / "typo.rscd"
    text = MODEL.read_text(encoding="utf-8")
    wrong = text.replace("{ state: LineDetector.no_line }", "{ stat: LineDetector.no_line }")
    assert wrong != text
    model.write_text(wrong, encoding="utf-8")
    done = example_workspace.run("rosrun", "robosc", "check", str(model), check=False)
    assert done.returncode == 1
    assert "unknown-property" in done.stderr


def test_no_other_executable_bears_the_name_of_a_verb() -> None:
    """rosrun looks into every folder below the package, and asks if it finds several."""
    found = {
        path.relative_to(REPOSITORY).as_posix()
        for folder, _, names in os.walk(REPOSITORY)
        for path in map(Path(folder).joinpath, {*VERBS}.intersection(names))
        if path.is_file() and os.access(path, os.X_OK)
    }
    assert found == {f"robosc_ros1/scripts/{verb}" for verb in VERBS}
