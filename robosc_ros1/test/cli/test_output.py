"""What the commands print: results on standard output, messages on standard error, JSON as told."""

from __future__ import annotations

import json
import os
import pty
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path
from typing import Any

import models
import pytest
from ros_support import REPOSITORY, SOURCES, Completed, run_robosc

from robosc import __version__
from robosc.verbs import VERBS

Robosc = Callable[..., Completed]


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    """All the models, ``good.rscd`` and so on."""
    for name in ("GOOD", "WITH_ERRORS", "EMPTY_SUPERVISOR", "NEVER", "LIBRARY", "LARGE"):
        text: str = getattr(models, name)
        (tmp_path / f"{name.lower()}.rscd").write_text(text, encoding="utf-8")
    return tmp_path


def document(done: Completed) -> Any:
    """The JSON document on standard output, which holds nothing else."""
    return json.loads(done.stdout)


def test_version(robosc: Robosc) -> None:
    done = robosc("--version")
    assert (done.returncode, done.stdout) == (0, f"robosc {__version__}\n")


@pytest.mark.parametrize("verb", [verb.name for verb in VERBS])
def test_help_has_an_example(verb: str, robosc: Robosc) -> None:
    done = robosc(verb, "--help")
    assert done.returncode == 0
    assert f"example: robosc {verb} " in done.stdout
    assert done.stderr == ""


def test_each_verb_is_an_executable_for_rosrun() -> None:
    scripts = REPOSITORY / "robosc_ros1" / "scripts"
    assert {p.name for p in scripts.iterdir()} == {verb.name for verb in VERBS} | {"robosc"}
    for verb in VERBS:
        assert f'run("{verb.name}")' in (scripts / verb.name).read_text(encoding="utf-8")
        assert os.access(scripts / verb.name, os.X_OK)


def test_check_says_that_all_is_well_on_stdout_alone(robosc: Robosc, folder: Path) -> None:
    done = robosc("check", "good.rscd")
    assert (done.stdout, done.stderr) == ("1 file: 0 errors, 0 warnings\n", "")


def test_check_shows_the_place_with_a_caret(robosc: Robosc, folder: Path) -> None:
    done = robosc("check", "with_errors.rscd")
    assert "with_errors.rscd:8:32: error[unknown-member]: " in done.stderr
    assert "\n    8 |     requirement go needs Motor.idel\n" in done.stderr
    assert "^^^^ did you mean 'idle'?" in done.stderr
    assert done.stdout == "1 file: 2 errors, 0 warnings\n"


def test_check_json(robosc: Robosc, folder: Path) -> None:
    done = robosc("check", "--json", "with_errors.rscd")
    assert done.returncode == 1
    found = document(done)
    assert found["version"] == 1
    assert [d["line"] for d in found["diagnostics"]] == [5, 8]
    last = found["diagnostics"][1]
    assert set(last) == {
        "file", "line", "column", "endLine", "endColumn", "severity", "code", "message", "hint",
    }  # fmt: skip
    assert last["file"] == "with_errors.rscd"
    assert (last["column"], last["endLine"], last["endColumn"]) == (32, 8, 36)
    assert (last["severity"], last["code"]) == ("error", "unknown-member")


def test_check_json_of_a_good_model_is_empty(robosc: Robosc, folder: Path) -> None:
    assert document(robosc("check", "--json", "good.rscd")) == {"version": 1, "diagnostics": []}


def test_check_warns_of_a_command_that_can_never_happen(robosc: Robosc, folder: Path) -> None:
    done = robosc("check", "never.rscd")
    assert done.returncode == 0
    assert "warning[" in done.stderr
    assert "work_hard" in done.stderr
    assert "on error from work_hard goto" in done.stderr


def test_synthesize_json(robosc: Robosc, folder: Path) -> None:
    found = document(robosc("synthesize", "--json", "good.rscd"))
    assert found["version"] == 1
    assert found["robot"] == "Lamp"
    assert found["plant_states"] == 16
    assert found["controlled_states"] == 16
    assert isinstance(found["seconds"], float)
    assert found["engine"] == "explicit"
    (guard,) = found["guards"]
    assert guard["event"]["kind"] == "request"
    assert guard["event"]["name"] == "switch_light"
    assert guard["status"] == "as required"
    assert guard["guard"] == "dark.fresh and Bulb.lit != Bulb.is_dark"
    assert found["explanations"] == []
    assert isinstance(found["properties"], dict)


def test_synthesize_explains_what_can_never_happen(robosc: Robosc, folder: Path) -> None:
    found = document(robosc("synthesize", "--json", "never.rscd"))
    assert [g["status"] for g in found["guards"]] == ["never"]
    (explanation,) = found["explanations"]
    assert explanation["event"]["name"] == "work_hard"
    assert [e["kind"] for e in explanation["trace"]] == ["request", "error"]
    assert "on error from work_hard goto" in explanation["remedy"]


def test_synthesize_text(robosc: Robosc, folder: Path) -> None:
    done = robosc("synthesize", "good.rscd")
    assert "16 of 16 states" in done.stdout
    assert (
        "switch_light.request  as required\n    dark.fresh and Bulb.lit != Bulb.is_dark\n"
        in done.stdout
    )
    assert done.stderr == ""


def test_explore_json(robosc: Robosc, folder: Path) -> None:
    found = document(robosc("explore", "--json", "good.rscd"))
    assert (found["version"], found["robot"], found["initial"]) == (1, "Lamp", 0)
    assert found["states"][0] == {
        "id": 0,
        "components": {"Bulb": "idle"},
        "variables": {"Bulb.is_dark": False, "Bulb.lit": False},
        "communications": {"dark": "silent", "switch_light": "idle"},
        "marked": True,
    }
    assert found["transitions"][1] == {
        "source": 0,
        "event": {"kind": "response", "name": "dark", "value": True},
        "controllable": False,
        "target": 2,
    }
    assert len(found["states"]) == 16


def test_explore_counts_what_synthesize_counts(robosc: Robosc, folder: Path) -> None:
    sizes = document(robosc("synthesize", "--json", "large.rscd"))
    graph = document(robosc("explore", "--json", "large.rscd"))
    assert len(graph["states"]) == sizes["controlled_states"]
    listed = (t.get("values", 1) for t in graph["transitions"])
    assert sum(listed) == sizes["controlled_transitions"]


def test_explore_of_the_plant_knows_no_requirement(robosc: Robosc, folder: Path) -> None:
    def requests(*options: str) -> int:
        graph = document(robosc("explore", "--json", *options, "good.rscd"))
        return sum(t["event"]["kind"] == "request" for t in graph["transitions"])

    assert requests() < requests("--plant")


def test_explore_text(robosc: Robosc, folder: Path) -> None:
    lines = robosc("explore", "good.rscd").stdout.splitlines()
    assert lines[0].startswith("Lamp: 16 states, ")
    assert lines[1] == "0*  Bulb.idle, Bulb.is_dark = false, Bulb.lit = false"
    assert "      dark.response(true) -> 2" in lines


def test_one_of_a_thing_has_no_plural(robosc: Robosc, folder: Path) -> None:
    behaviour = "outgoing message m with type: none behaviour { initial marked state on {} }"
    model = f"robot One {{ component C {{ {behaviour} }} }}"
    (folder / "one.rscd").write_text(model, encoding="utf-8")
    for verb in ("explore", "verify"):
        assert robosc(verb, "one.rscd").stdout.startswith("One: 1 state, 1 transition\n")
    start = "One: 1 of 1 state under control, 1 transition ("
    assert robosc("synthesize", "one.rscd").stdout.startswith(start)


@pytest.mark.slow
def test_output_is_the_same_each_time(robosc: Robosc, folder: Path) -> None:
    first = robosc("explore", "--json", "large.rscd", PYTHONHASHSEED="1").stdout
    assert first == robosc("explore", "--json", "large.rscd", PYTHONHASHSEED="2").stdout


@pytest.mark.slow
@pytest.mark.parametrize(
    ("environment", "colored"),
    [({}, True), ({"NO_COLOR": "1"}, False), ({"TERM": "dumb"}, False)],
    ids=["terminal", "NO_COLOR", "dumb terminal"],
)
def test_color_only_on_terminals_that_want_it(
    environment: dict[str, str], colored: bool, folder: Path
) -> None:
    env = {k: v for k, v in os.environ.items() if k != "NO_COLOR"}
    env |= {"PYTHONPATH": str(SOURCES), "TERM": "xterm"} | environment
    try:
        ours, theirs = pty.openpty()
    except OSError as error:
        pytest.skip(f"there are no pseudo-terminals here: {error}")
    try:
        subprocess.run(
            [sys.executable, "-m", "robosc", "check", "with_errors.rscd"],
            cwd=folder,
            env=env,
            stderr=theirs,
            stdout=subprocess.DEVNULL,
            timeout=600,
        )
        shown = os.read(ours, 100_000).decode()
    finally:
        os.close(ours)
        os.close(theirs)
    assert "did you mean" in shown
    assert ("\x1b[" in shown) is colored


def test_no_color_in_pipes(robosc: Robosc, folder: Path) -> None:
    assert "\x1b" not in robosc("check", "with_errors.rscd").stderr


def test_characters_that_the_terminal_cannot_show_are_escaped(robosc: Robosc, folder: Path) -> None:
    text = models.WITH_ERRORS.replace("requirement", "/* größer */ requirement")
    (folder / "umlaut.rscd").write_text(text, encoding="utf-8")
    done = robosc("check", "umlaut.rscd", PYTHONIOENCODING="ascii", PYTHONUTF8="0")
    assert done.returncode == 1
    assert "gr\\xf6\\xdfer" in done.stderr


@pytest.mark.slow
@pytest.mark.parametrize("locale", ["C", "POSIX", "C.UTF-8"])
def test_any_locale_will_do(locale: str, robosc: Robosc, folder: Path) -> None:
    (folder / "größer.rscd").write_text(models.GOOD, encoding="utf-8")
    assert robosc("check", "größer.rscd", LC_ALL=locale).returncode == 0


INTO_ROS_1 = "mkdir -p ~/catkin_ws/src && ln -sfn {there} ~/catkin_ws/src && cd ~/catkin_ws"


@pytest.mark.parametrize(
    ("called_in", "output", "target", "first"),
    [
        ("ws/src", ".", "ros1", "cd .."),
        ("ws/src/a folder", "..", "ros1", "cd ../.."),
        ("ws", "src", "ros1", "catkin_make && source devel/setup.bash"),
        ("", "ws/src", "ros1", "cd ws"),
        ("", "my ws/src", "ros1", "cd 'my ws'"),
        ("", "elsewhere", "ros1", INTO_ROS_1.format(there="'{0}/elsewhere/g_controller'")),
        ("", ".", "ros1", INTO_ROS_1.format(there="'{0}/g_controller'")),
        ("ws/src", ".", "ros2", "cd .."),
        ("", ".", "ros2", "colcon build && source install/setup.bash"),
        ("elsewhere", "..", "ros2", "cd .."),
    ],
)
def test_next_commands_lead_to_the_workspace(
    folder: Path, called_in: str, output: str, target: str, first: str
) -> None:
    home = folder / "of somebody"
    for where in ("ws/src/a folder", "my ws/src", "elsewhere"):
        (home / where).mkdir(parents=True)
    arguments = ["--output", output, "--target", target, "--package", "g_controller"]
    model = str(folder / "good.rscd")
    done = run_robosc(["generate", model, *arguments], home / called_in, {})
    _, _, commands = done.stdout.partition("next:\n")
    lines = [line.strip() for line in commands.splitlines()]
    assert lines[0] == first.format(home)
    verbs = ["roslaunch", "catkin_make"] if target == "ros1" else ["ros2", "colcon"]
    assert [line.partition(" ")[0] for line in lines[-2:]] == verbs


def test_files_are_listed_only_if_that_is_asked_for(folder: Path) -> None:
    model = str(folder / "good.rscd")
    short = run_robosc(["generate", model], folder, {}).stdout
    assert "package.xml" not in short and " written, 0 unchanged\n" in short
    long = run_robosc(
        ["generate", model, "--verbose", "--force", "--package", "x_controller"], folder, {}
    )
    assert "\n    package.xml\n" in long.stdout


@pytest.mark.skipif(
    not Path("/usr/lib/python3/dist-packages/catkin_pkg").is_dir(), reason="catkin is not installed"
)
def test_another_python_first_on_path_is_not_given_to_catkin(folder: Path) -> None:
    (folder / "conda").mkdir()
    (folder / "conda" / "python3").symlink_to(sys.executable)
    done = subprocess.run(
        [sys.executable, "-m", "robosc", "generate", str(folder / "good.rscd")],
        cwd=folder,
        env={"PYTHONPATH": str(SOURCES), "PATH": f"{folder / 'conda'}:/usr/bin:/bin"},
        capture_output=True,
        text=True,
        check=True,
    )
    assert "    PATH=/usr/bin:$PATH catkin_make && source devel/setup.bash\n" in done.stdout
    assert "    PATH=/usr/bin:$PATH catkin_make run_tests_" in done.stdout
