"""What the README shows is what robosc does."""

from __future__ import annotations

import re
import subprocess
from collections.abc import Callable
from pathlib import Path

import pytest
from ros_support import REPOSITORY, Completed

Robosc = Callable[..., Completed]

TEXT = (REPOSITORY / "README.md").read_text(encoding="utf-8")
BLOCKS = re.findall(r"^```\n(.*?)^```$", TEXT, re.DOTALL | re.MULTILINE)
MODELS = {match.group(1): b for b in BLOCKS if (match := re.match(r"robot (\w+) \{", b))}
HANDLED = "                on error from turn goto resting\n"


def folded(text: str) -> str:
    return " ".join(text.split())


@pytest.fixture
def door(tmp_path: Path) -> Path:
    file = tmp_path / "door.rscd"
    file.write_text(MODELS["Door"], encoding="utf-8")
    return file


def shown(command: str) -> list[str]:
    """What the README shows as output of a command, in order."""
    return [b.removeprefix(f"$ {command}\n") for b in BLOCKS if b.startswith(f"$ {command}\n")]


def test_first_model_is_ten_lines_and_good(robosc: Robosc, tmp_path: Path) -> None:
    model = MODELS["Rover"]
    assert len(model.splitlines()) == 10
    (tmp_path / "model.rscd").write_text(model, encoding="utf-8")
    assert robosc("check", "model.rscd").stdout == "1 file: 0 errors, 0 warnings\n"


def test_forgotten_error_is_explained_as_shown(robosc: Robosc, door: Path) -> None:
    done = robosc("check", "door.rscd")
    first, _ = shown("robosc check door.rscd")
    assert folded(first) in folded(done.stderr)


def test_mended_door_is_as_shown(robosc: Robosc, door: Path) -> None:
    text = door.read_text(encoding="utf-8")
    anchor = "                on response from turn goto resting\n"
    assert any(anchor + HANDLED in block for block in BLOCKS)
    door.write_text(text.replace(anchor, anchor + HANDLED), encoding="utf-8")
    _, second = shown("robosc check door.rscd")
    done = robosc("check", "door.rscd")
    assert (done.stdout, done.stderr) == (second, "")
    (guards,) = shown("robosc synthesize door.rscd")
    timeless = re.compile(r"\d+\.\d\d s")
    assert timeless.sub("", robosc("synthesize", "door.rscd").stdout).startswith(
        timeless.sub("", guards)
    )


def test_links_lead_somewhere() -> None:
    for page in ("README.md", "CONTRIBUTING.md", *map(str, REPOSITORY.glob("examples/*/*.md"))):
        file = REPOSITORY / page
        for target in re.findall(r"\]\(([^)#:]+)\)", file.read_text(encoding="utf-8")):
            assert (file.parent / target).exists(), f"{page}: {target}"


def test_dev_knows_what_is_told() -> None:
    done = subprocess.run([REPOSITORY / "dev", "--help"], capture_output=True, text=True)
    assert done.returncode == 0
    for word in ("setup", "demo", "test", "lint", "bench"):
        assert f"./dev {word}" in done.stdout
    wrong = subprocess.run([REPOSITORY / "dev", "frobnicate"], capture_output=True, text=True)
    assert wrong.returncode == 2
    assert "usage" in wrong.stderr
