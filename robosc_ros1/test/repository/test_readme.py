"""What the README shows is what robosc does."""

from __future__ import annotations

import re
import runpy
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


def test_demo_ends_as_shown(
    capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    (block,) = (b for b in BLOCKS if b.startswith("== What happened\n"))
    number = r"[\d.]+"
    pattern = re.compile(
        rf"distance driven +(?P<metres>{number}) m\n +stops +(?P<stops>\d+)\n +grabs +(?P<grabs>\d+),"
        rf" (?P<missed_grabs>\d+) .*\n +light switches +(?P<light_switches>\d+)\n +violations +0 +"
        rf"\(of (?P<commands_judged>\d+) .*tolerance (?P<tolerance>{number}) s"
    )
    found = pattern.search(block)
    assert found is not None, block
    summary = {name: float(n) if "." in n else int(n) for name, n in found.groupdict().items()}
    monkeypatch.syspath_prepend(str(REPOSITORY / "examples" / "line_follower"))
    demo = runpy.run_path(str(REPOSITORY / "examples" / "line_follower" / "demo.py"))
    demo["tell"]({**summary, "violations": {}}, REPOSITORY / ".cache" / "demo" / "path.png", 60.0)
    *told, _time = capsys.readouterr().out.strip("\n").splitlines()
    assert told == block.splitlines()


def test_the_session_with_a_generated_package_names_what_there_is(
    robosc: Robosc, door: Path, tmp_path: Path
) -> None:
    """Commands that are shown without output: each package, file, node and topic of them exists."""
    (session,) = (b for b in BLOCKS if b.startswith("$ robosc generate"))
    package, launch = re.findall(r"^\$ roslaunch (\S+) (\S+)$", session, re.MULTILINE)[0]
    door.write_text(door.read_text().replace("goto resting\n", "goto resting\n" + HANDLED))
    assert robosc("generate", "door.rscd").returncode == 0
    assert (tmp_path / package / "launch" / launch).is_file()
    (others,) = (b for b in BLOCKS if b.startswith("$ rosrun robosc simulated_door"))
    assert (REPOSITORY / "examples" / "door" / "simulated_door").is_file()
    assert "$ rostopic echo /door/position\n" in others and '"/door/position"' in MODELS["Door"]
    assert f"$ rosrun robosc view --ros /{package}\n" in others


def test_every_verb_that_is_named_exists() -> None:
    named = set(
        re.findall(r"(?:run robosc|robosc-venv/bin/robosc|`robosc|\$ robosc) ([a-z]+)", TEXT)
    )
    known = {file.name for file in (REPOSITORY / "robosc_ros1" / "scripts").iterdir()}
    assert named - {"simulated"} <= known


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
