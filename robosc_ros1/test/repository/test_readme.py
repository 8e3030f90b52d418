"""What the README shows is what robosc does."""

from __future__ import annotations

import re
import runpy
import shlex
import subprocess
import textwrap
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


RUN = """\
expect disabled move
scan ranges: [Infinity, Infinity, Infinity]
expect enabled move
scan ranges: [Infinity, 0.3, NaN]
expect disabled move
expect enabled halt
scan ranges: [2.0, NaN]
expect enabled move
scan ranges: []
expect disabled move
"""


def rovers() -> dict[str, str]:
    """The first model of each page, without what indents it."""
    pages = [REPOSITORY / name for name in ("README.md", "docs/ros2.md", "docs/tutorial.md")]
    texts = [page.read_text(encoding="utf-8") for page in pages]
    found = [
        re.search(r"^( *)robot Rover \{\n.*?^\1\}\n", t, re.DOTALL | re.MULTILINE) for t in texts
    ]
    return {p.name: textwrap.dedent(f[0]) for p, f in zip(pages, found, strict=True) if f}


@pytest.mark.parametrize("page", ["README.md", "ros2.md", "tutorial.md"])
def test_first_model_is_short_and_drives_in_the_open(
    page: str, robosc: Robosc, tmp_path: Path
) -> None:
    model = rovers()[page]
    assert len(model.splitlines()) < 25
    (tmp_path / "model.rscd").write_text(model, encoding="utf-8")
    (tmp_path / "run.sim").write_text(RUN, encoding="utf-8")
    assert robosc("check", "model.rscd").stdout == "1 file: 0 errors, 0 warnings\n"
    for more in ([], ["--execute"]):
        done = robosc("simulate", "model.rscd", "--script", "run.sim", *more)
        assert done.stdout == "run.sim: 6 of 6 expectations met\n", done.stderr


def test_each_step_of_the_tutorial_is_an_example() -> None:
    """Each line of a model that the page shows stands in the model of its step."""
    folder = REPOSITORY / "examples" / "tutorial"
    text = (REPOSITORY / "docs" / "tutorial.md").read_text(encoding="utf-8")
    named = re.findall(r"^## (\d)\. .*?\n(.*?)(?=^## |\Z)", text, re.DOTALL | re.MULTILINE)
    assert [number for number, _ in named] == list("12345678")
    for number, section in named[:5]:
        (file,) = folder.glob(f"{number}_*.rscd")
        there = "".join(file.read_text(encoding="utf-8").split())
        for block in re.findall(r"^```\w*\n(.*?)^```$", section, re.DOTALL | re.MULTILINE):
            if not block.startswith("$"):
                for line in block.splitlines():
                    assert "".join(line.split()) in there, (file.name, line)


def test_the_workflow_of_the_tutorial_runs(robosc: Robosc, tmp_path: Path) -> None:
    yaml = pytest.importorskip("yaml")
    folder = REPOSITORY / "examples" / "tutorial"
    (tmp_path / "models").mkdir()
    for file in folder.glob("[1-5]_*"):
        (tmp_path / "models" / file.name).write_bytes(file.read_bytes())
    workflow = yaml.safe_load((folder / "check.yml").read_text(encoding="utf-8"))
    steps = [step["run"] for step in workflow["jobs"]["models"]["steps"] if "run" in step]
    verbs = [run for run in steps if run.startswith("venv/bin/robosc ")]
    assert len(verbs) == 3
    for run in verbs:
        done = robosc(*shlex.split(run)[1:])
        assert done.returncode == 0, done.stdout + done.stderr
    assert (tmp_path / "mission.xml").is_file()
    assert (tmp_path / "generated" / "rover_controller" / "package.xml").is_file()


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
    summary |= {"violations": {}, "late": 0.02}
    demo["tell"](summary, REPOSITORY / ".cache" / "demo" / "path.png", 60.0)
    *told, _time = capsys.readouterr().out.strip("\n").splitlines()
    assert told == block.splitlines()
    demo["tell"](summary | {"late": 0.3}, REPOSITORY / ".cache" / "demo" / "path.png", 60.0)
    assert "0.30 s more where the machine was late" in capsys.readouterr().out


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
