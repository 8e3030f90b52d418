"""Exit codes: 0 done, 1 the model has errors, 2 usage, 3 empty, 4 too large, 130 interrupted.

Nothing that a user can cause shows a Python traceback.
"""

from __future__ import annotations

import ast
import json
import math
import os
import re
import signal
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path

import models
import pytest
from families import switches
from ros_support import EXAMPLES, SOURCES, Completed, await_condition, state_of

from robosc import limits, pipeline
from robosc.synthesis.bdd.manager import available

Robosc = Callable[..., Completed]

VERBS = ("check", "synthesize", "explore", "generate", "verify")


@pytest.fixture
def model(tmp_path: Path) -> Callable[[str], str]:
    """Writes a model into the test's folder; the name of the file."""

    def write(text: str) -> str:
        (tmp_path / "model.rscd").write_text(text, encoding="utf-8")
        return "model.rscd"

    return write


def code(done: Completed) -> int:
    assert "Traceback" not in done.stderr
    return done.returncode


@pytest.mark.parametrize("verb", VERBS)
def test_good_model_is_done(verb: str, robosc: Robosc, model: Callable[[str], str]) -> None:
    assert code(robosc(verb, model(models.GOOD))) == 0


@pytest.mark.parametrize("verb", VERBS)
def test_errors_in_the_model(verb: str, robosc: Robosc, model: Callable[[str], str]) -> None:
    done = robosc(verb, model(models.WITH_ERRORS))
    assert code(done) == 1
    assert "model.rscd:5:" in done.stderr
    assert "model.rscd:8:" in done.stderr
    assert "did you mean" in done.stderr


@pytest.mark.parametrize("verb", VERBS)
def test_missing_file(verb: str, robosc: Robosc) -> None:
    done = robosc(verb, "nowhere/to/be/found.rscd")
    assert code(done) == 2
    assert "nowhere/to/be/found.rscd" in done.stderr
    assert done.stdout == ""


@pytest.mark.parametrize(
    "name",
    [
        "", "with-dash", "../up", "json", "std_msgs", "numpy", "robosc",
        "player", "ros_player", "robot_tables",
    ],
)  # fmt: skip
def test_what_cannot_be_a_package(
    name: str, robosc: Robosc, model: Callable[[str], str], tmp_path: Path
) -> None:
    done = robosc("generate", model(models.GOOD), "--package", name)
    assert code(done) == 2
    assert f"{name!r} is not a valid name for a package" in done.stderr
    assert [p.name for p in tmp_path.iterdir()] == ["model.rscd"]


@pytest.mark.parametrize("verb", VERBS)
def test_folder_instead_of_a_file(verb: str, robosc: Robosc, tmp_path: Path) -> None:
    (tmp_path / "folder").mkdir()
    assert code(robosc(verb, "folder")) == 2


@pytest.mark.parametrize(
    "arguments",
    [
        (),
        ("frobnicate",),
        ("check",),
        ("check", "--frobnicate", "x.rscd"),
        ("synthesize", "--max-states", "none", "x.rscd"),
        ("synthesize", "--max-states", "0", "x.rscd"),
        ("synthesize", "--engine", "steam", "x.rscd"),
        ("explore", "--limit", "-3", "x.rscd"),
        ("generate", "--target", "ros3", "x.rscd"),
        ("check", "--library-path", "nowhere", "x.rscd"),
    ],
    ids=" ".join,
)
def test_wrong_usage(arguments: tuple[str, ...], robosc: Robosc) -> None:
    done = robosc(*arguments)
    assert code(done) == 2
    assert "usage: robosc" in done.stderr


def test_an_unknown_argument_shows_what_the_verb_takes(robosc: Robosc) -> None:
    done = robosc("report", "cart.rscd", "events.jsonl")
    assert code(done) == 2
    assert done.stderr.startswith("usage: robosc report ") and "--logs" in done.stderr
    assert done.stderr.endswith("robosc report: error: unrecognized arguments: events.jsonl\n")
    assert done.stdout == ""


@pytest.mark.parametrize("verb", ["synthesize", "explore", "generate", "verify"])
def test_library_where_a_robot_is_needed(
    verb: str, robosc: Robosc, model: Callable[[str], str]
) -> None:
    done = robosc(verb, model(models.LIBRARY))
    assert code(done) == 2
    assert "library" in done.stderr


@pytest.mark.parametrize("verb", VERBS)
def test_empty_supervisor(verb: str, robosc: Robosc, model: Callable[[str], str]) -> None:
    done = robosc(verb, model(models.EMPTY_SUPERVISOR))
    assert code(done) == 3
    assert "Doomed" in done.stderr


def test_too_many_states_for_the_limits(robosc: Robosc, model: Callable[[str], str]) -> None:
    name = model(models.LARGE)
    assert code(robosc("synthesize", "--engine", "explicit", "--max-states", "100", name)) == 4
    done = robosc("explore", "--limit", "100", name)
    assert code(done) == 4
    assert done.stdout == ""


@pytest.mark.slow
@pytest.mark.parametrize(
    "values", ["0..20000", "0..2147483647", "-9223372036854775808..9223372036854775807"]
)
def test_ranges_that_nobody_can_enumerate(
    values: str,
    robosc: Robosc,
    model: Callable[[str], str],
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.setattr(limits, "CHECK_SECONDS", math.inf)
    name = model(models.WIDE.replace("RANGE", values))
    done = robosc("check", "--json", name)
    assert code(done) == 0
    # The symbolic engine, where it is installed, still enumerates the first.
    enumerable = available() and values == "0..20000"
    unchecked = [
        d["message"].startswith("checked without synthesis: ")
        for d in json.loads(done.stdout)["diagnostics"]
        if d["code"] == "synthesis-unchecked"
    ]
    assert unchecked == ([] if enumerable else [True])
    done = robosc("synthesize", "--engine", "explicit", name)
    assert code(done) == 4
    assert "convert" in done.stderr


def test_a_check_that_takes_too_long_says_so(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(limits, "CHECK_SECONDS", 0.0)
    (tmp_path / "good.rscd").write_text(models.GOOD, encoding="utf-8")
    checked = pipeline.check(tmp_path / "good.rscd")
    assert [d.code for d in checked.diagnostics] == ["synthesis-unchecked"]


def test_a_large_robot_without_controller_is_found_out(tmp_path: Path) -> None:
    doomed = "component A { outgoing message m with type: none behaviour {"
    doomed += " initial marked state a { on response from m goto b } marked state b {} } }"
    doomed += " requirement never A.b"
    text = f"robot Large {{ {switches(310)} {doomed} }}"
    (tmp_path / "large.rscd").write_text(text, encoding="utf-8")
    checked = pipeline.check(tmp_path / "large.rscd")
    assert checked.exit_code == (3 if available() else 0)
    expected = "empty-supervisor" if available() else "synthesis-unchecked"
    assert expected in {d.code for d in checked.diagnostics}


def test_worst_of_several_files_counts(robosc: Robosc, tmp_path: Path) -> None:
    (tmp_path / "good.rscd").write_text(models.GOOD, encoding="utf-8")
    (tmp_path / "bad.rscd").write_text(models.WITH_ERRORS, encoding="utf-8")
    done = robosc("check", "good.rscd", "bad.rscd")
    assert code(done) == 1
    assert "2 files: 2 errors, 0 warnings" in done.stdout


def test_a_file_that_cannot_be_read_hides_no_other(robosc: Robosc, tmp_path: Path) -> None:
    (tmp_path / "bad.rscd").write_text(models.WITH_ERRORS, encoding="utf-8")
    done = robosc("check", "nowhere.rscd", "bad.rscd")
    assert code(done) == 2
    assert "bad.rscd:5:" in done.stderr
    assert "cannot read nowhere.rscd" in done.stderr


def test_a_file_that_is_named_twice_is_checked_once(robosc: Robosc, tmp_path: Path) -> None:
    (tmp_path / "bad.rscd").write_text(models.WITH_ERRORS, encoding="utf-8")
    done = robosc("check", "bad.rscd", "./bad.rscd")
    assert code(done) == 1
    assert done.stdout.startswith("1 file: ")


@pytest.mark.parametrize(
    "content",
    [b"", b"\x00\x01\x02", b"robot", b"\xff\xfe\xfa", b"robot R {", b"(" * 10000],
    ids=["empty", "binary", "no name", "no UTF-8", "no end", "parentheses"],
)
def test_what_is_no_model_is_an_error_of_the_model(
    content: bytes, robosc: Robosc, tmp_path: Path
) -> None:
    (tmp_path / "model.rscd").write_bytes(content)
    assert code(robosc("check", "model.rscd")) == 1


def test_python_without_the_libraries_is_told(model: Callable[[str], str], tmp_path: Path) -> None:
    done = subprocess.run(
        [sys.executable, "-S", "-m", "robosc", "check", model(models.GOOD)],
        cwd=tmp_path,
        env={"PYTHONPATH": str(SOURCES)},
        capture_output=True,
        text=True,
    )
    assert code(done) == 2
    assert f"{sys.executable} has no module" in done.stderr


def test_interrupt_ends_quietly(tmp_path: Path) -> None:
    """A named pipe as the model: the command waits for its content until it is interrupted."""
    pipe = tmp_path / "model.rscd"
    os.mkfifo(pipe)
    process = subprocess.Popen(
        [sys.executable, "-m", "robosc", "check", str(pipe)],
        env=os.environ | {"PYTHONPATH": str(SOURCES)},
        stderr=subprocess.PIPE,
        text=True,
    )
    with pipe.open("wb"):  # returns when the command has opened its end
        # Between opening and reading, Python keeps an interrupt until it has read something.
        await_condition(lambda: state_of(process.pid) == "S", "the command to read")
        process.send_signal(signal.SIGINT)
        _, errors = process.communicate(timeout=600)
    assert process.returncode == 130
    assert "Traceback" not in errors


@pytest.mark.parametrize(
    ("verb", "module"),
    [
        *(("check", name) for name in ("robosc.start", "enum", "robosc.cli", "argparse")),
        ("synthesize", "robosc.synthesis.compute"),
        ("generate", "jinja2.environment"),
        ("simulate", "robosc.simulate.script.session"),
    ],
)
def test_interrupt_while_modules_are_loaded_is_quiet(
    tmp_path: Path, model: Callable[[str], str], verb: str, module: str
) -> None:
    """Python runs ``sitecustomize`` before everything else; here it waits for an import."""
    (tmp_path / "sitecustomize.py").write_text(
        "import os, sys\n"
        f"sys.modules.pop({module!r}, None)\n"
        "class Watch:\n"
        "    def find_spec(self, name, path=None, target=None):\n"
        f"        if name == {module!r}:\n"
        "            os.kill(os.getpid(), 2)\n"
        "sys.meta_path.insert(0, Watch())\n"
    )
    done = subprocess.run(
        [sys.executable, "-m", "robosc", verb, model(models.GOOD)],
        cwd=tmp_path,
        env=os.environ | {"PYTHONPATH": f"{tmp_path}{os.pathsep}{SOURCES}"},
        capture_output=True,
    )
    assert (done.returncode, done.stdout, done.stderr) == (130, b"", b"")
    assert sorted(path.suffix for path in tmp_path.iterdir() if path.is_file()) == [".py", ".rscd"]


def test_reader_that_has_seen_enough_is_no_error(
    tmp_path: Path, model: Callable[[str], str]
) -> None:
    process = subprocess.Popen(
        [sys.executable, "-m", "robosc", "explore", "--json", model(models.LARGE)],
        cwd=tmp_path,
        env=os.environ | {"PYTHONPATH": str(SOURCES)},
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
    )
    assert process.stdout is not None and process.stderr is not None
    process.stdout.read(10)
    process.stdout.close()
    assert process.stderr.read() == b""
    process.stderr.close()
    assert process.wait(timeout=600) == 0


def in_shell(script: str, folder: Path, *arguments: str) -> Completed:
    """Runs a script of the shell, in which ``"$@"`` is robosc with its arguments."""
    words = [sys.executable, "-m", "robosc", *arguments]
    return subprocess.run(
        ["sh", "-c", script, "sh", *words],
        cwd=folder,
        env={**os.environ, "PYTHONPATH": str(SOURCES)},
        capture_output=True,
        text=True,
        check=False,
        timeout=600,
    )


@pytest.mark.slow
@pytest.mark.parametrize("arguments", [("check",), ("check", "--json"), ("generate",)])
@pytest.mark.parametrize("redirection", [">&-", "2>&-", ">&- 2>&- <&-", "2>/dev/full"])
def test_streams_that_are_closed_change_nothing(
    arguments: tuple[str, ...], redirection: str, model: Callable[[str], str], tmp_path: Path
) -> None:
    done = in_shell(f'"$@" {redirection}', tmp_path, *arguments, model(models.GOOD))
    assert code(done) == 0
    assert (tmp_path / "lamp_controller" / "package.xml").exists() == ("generate" in arguments)


@pytest.mark.slow
@pytest.mark.parametrize("arguments", [("check", "model.rscd"), ("--help",), ("check", "--help")])
def test_a_result_that_cannot_be_written_is_told(
    arguments: tuple[str, ...], model: Callable[[str], str], tmp_path: Path
) -> None:
    model(models.GOOD)
    done = in_shell('"$@" >/dev/full', tmp_path, *arguments)
    assert code(done) == 2
    assert done.stderr == "error: cannot write the result: No space left on device\n"
    assert code(in_shell('"$@" >/dev/full 2>&1', tmp_path, *arguments)) == 2


def test_a_folder_that_is_gone_is_told(tmp_path: Path) -> None:
    script = 'mkdir here && cd here && rmdir ../here && "$@"'
    done = in_shell(script, tmp_path, "check", "../model.rscd")
    assert code(done) == 2
    assert done.stderr.startswith("error: the current folder is gone")


def test_a_command_that_used_diagrams_leaves_with_all_that_it_wrote() -> None:
    """It does not free them, but what others have registered for its end is done."""
    pytest.importorskip("oxidd")
    model = str(EXAMPLES / "line_follower" / "line_follower.rscd")
    words = ["robosc", "synthesize", model, "--engine", "bdd", "--json"]
    code = (
        "import atexit, sys; atexit.register(print, 'over'); from robosc.start import run;"
        f" sys.argv = {words!r}; run(); print('freed')"
    )
    done = subprocess.run(
        [sys.executable, "-c", code],
        env=os.environ | {"PYTHONPATH": os.pathsep.join([str(SOURCES), *sys.path])},
        capture_output=True,
        text=True,
    )
    assert done.returncode == 0, done.stderr
    document, _, rest = done.stdout.rpartition("}")
    assert rest.split() == ["over"]
    assert json.loads(document + "}")["engine"] == "bdd"


def test_a_python_that_is_too_old_is_told() -> None:
    """As of Ubuntu 20.04, where catkin builds robosc and warns: what runs until then is Python 3.8."""
    code = (
        "import sys; sys.hexversion = 0x03080AF0; sys.argv = ['robosc', 'check', 'x.rscd'];"
        " from robosc.start import run; raise SystemExit(run())"
    )
    env = os.environ | {"PYTHONPATH": str(SOURCES)}
    done = subprocess.run([sys.executable, "-c", code], env=env, capture_output=True, text=True)
    assert done.returncode == 2
    assert re.fullmatch(r"error: .+ is Python 3\S+, and robosc needs 3.10 .+\n", done.stderr)
    for name in ("__init__", "__main__", "start"):
        ast.parse((SOURCES / "robosc" / f"{name}.py").read_text("utf-8"), feature_version=(3, 8))
