"""Models shaped like the original's eight scenarios, with its own kind of options beside them."""

from __future__ import annotations

import json
import shutil
from collections.abc import Callable, Iterator
from pathlib import Path

import pytest
from ros2.launching import Node, started
from ros_support import Completed

FOLDER = Path(__file__).parent
MODELS = sorted(path.stem for path in FOLDER.glob("models/*.rscd"))
OPTIONS = {
    "writeEventsToLog": True,
    "output": {
        "ros1ControllerNodeLocation": "../ros1/controller",
        "ros2ControllerNodeLocation": "../ros2/controller",
        "ros2SupervisorNodeLocation": "../ros2/supervisor",
    },
    "supervisor": {
        "controller": {
            "run": {
                "packageName": "line_follower",
                "namespace": "",
                "executable": "follow",
                "name": "follower",
            }
        }
    },
}


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    for part in ("models", "libraries"):
        shutil.copytree(FOLDER / part, tmp_path / part)
    # As in the original's own projects, the options lie in a folder below the model.
    (tmp_path / "models" / "config").mkdir()
    file = tmp_path / "models" / "config" / "controller-config.json"
    file.write_text(json.dumps(OPTIONS), encoding="utf-8")
    return tmp_path


@pytest.mark.parametrize("model", MODELS)
@pytest.mark.parametrize("target", ["ros1", "ros2"])
def test_scenarios_are_generated_with_the_original_s_options(
    model: str, target: str, folder: Path, robosc: Callable[..., Completed]
) -> None:
    done = robosc("generate", f"models/{model}.rscd", "--target", target)
    assert done.returncode == 0, done.stderr
    assert "never-allowed" not in done.stderr
    package = folder / target / "controller"
    assert (package / "package.xml").is_file()
    (config,) = (package / "config").iterdir()
    assert 'legacy_state_topic: "/state"' in config.read_text(encoding="utf-8")
    assert list(long_lines(package)) == []


def long_lines(package: Path) -> Iterator[str]:
    """Lines that could be broken, which those of tables, hashes and scripts could not, nor paths."""
    for path in package.rglob("*"):
        if path.is_file() and path.name != "generated.sha256" and path.suffix != ".sim":
            for line in path.read_text(encoding="utf-8").splitlines():
                if len(line) > 100 and not line.startswith("|") and "$(find" not in line:
                    yield f"{path.name}: {line}"


def test_the_supervisor_starts_the_controller_of_the_options(
    folder: Path, robosc: Callable[..., Completed]
) -> None:
    mode = ("--target", "ros2", "--mode", "supervisor")
    done = robosc("generate", "models/supervised.rscd", *mode)
    assert done.returncode == 0, done.stderr
    (launch,) = (folder / "ros2" / "supervisor" / "launch").iterdir()
    pytest.importorskip("yaml")
    _, follower = started(launch, str)
    assert isinstance(follower, Node)
    assert (follower.package, follower.executable) == ("line_follower", "follow")
