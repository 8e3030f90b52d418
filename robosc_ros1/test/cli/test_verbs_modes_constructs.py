"""Every verb in every mode with every construct: it does what it says, or says in a line why not.

A cell is one command line, run to its end in this process. What is expected of it is exit code 0,
unless a row of ``OTHERWISE`` says what the verb answers instead. CONTRIBUTING.md has the table.
"""

from __future__ import annotations

import json
import random
from collections.abc import Callable
from pathlib import Path

import pytest
from constructs import CONSTRUCTS, WHOLE, model
from runtime.schemas import validate

from robosc import pipeline
from robosc.cli import main
from robosc.simulate.machines.machine import label
from robosc.simulate.script.session import Session
from robosc.simulate.start import machine_maker
from robosc.view.hub import Hub
from robosc.view.played import Played

MODES = ("controller", "supervisor", "monitor")
OTHERWISE: dict[tuple[str, str, str], tuple[int, str]] = {
    ("commands corrected", "generate", "controller"): (1, "data-of-others")
}
"""Construct, verb and mode, with the exit code and a part of the message."""

# The half of the constructs that every quick run has; the others are slow.
QUICK = ("messages", "data of commands", "services and actions", *WHOLE)

Run = Callable[..., tuple[int, str, str]]


@pytest.fixture(
    params=[
        pytest.param(name, marks=() if name in QUICK else pytest.mark.slow)
        for name in (*CONSTRUCTS, *WHOLE)
    ]
)
def construct(request: pytest.FixtureRequest) -> str:
    if request.param == "transforms":
        pytest.importorskip("geometry_msgs.msg", reason="no geometry_msgs")
    return str(request.param)


@pytest.fixture(params=MODES)
def mode(request: pytest.FixtureRequest) -> str:
    return str(request.param)


@pytest.fixture
def path(construct: str, tmp_path: Path) -> Path:
    file = tmp_path / "small.rscd"
    file.write_text(model(construct), encoding="utf-8")
    return file


@pytest.fixture
def run(construct: str, mode: str, path: Path, capfd: pytest.CaptureFixture[str]) -> Run:
    """Runs a verb; its exit code and output, which are as expected."""

    def cell(verb: str, *words: str) -> tuple[int, str, str]:
        code = main([verb, str(path), *words, "--mode", mode])
        out, err = capfd.readouterr()
        key = (construct, verb, mode)
        wanted, told = OTHERWISE.get(key, (0, ""))
        assert code == wanted, f"{verb} {words}: {code}\n{out}\n{err}"
        assert told in err + out
        assert "Traceback" not in err
        return code, out, err

    return cell


def test_documents(run: Run) -> None:
    """What the verbs that print a document print."""
    for verb, *words in (
        ("check", "--json"), ("synthesize", "--json"), ("verify", "--json"),
        ("explore", "--json", "--limit", "100000"), ("explore", "--plant", "--json"),
        ("export", "--format", "json"),
    ):  # fmt: skip
        code, out, err = run(verb, *words)
        if code == 0:
            validate(json.loads(out), verb)
        else:
            assert err


def test_texts(run: Run) -> None:
    for verb, *words in (
        ("synthesize",), ("explore", "--limit", "100000"), ("verify",),
        ("export", "--format", "cif"), ("export", "--format", "dot"),
    ):  # fmt: skip
        code, out, err = run(verb, *words)
        assert out if code == 0 else err


@pytest.mark.parametrize("target", ["ros1", "ros2"])
def test_packages(run: Run, target: str, tmp_path: Path) -> None:
    code, out, _ = run("generate", "--target", target, "--output", str(tmp_path / "out"))
    assert bool(list((tmp_path / "out").rglob("*.py"))) is (code == 0)
    assert "Traceback" not in out


@pytest.mark.parametrize("execute", [False, True], ids=["single events", "execute"])
def test_sessions(mode: str, path: Path, execute: bool) -> None:
    """Each event is asked for, each command explained, and steps are drawn at random."""
    session = _session(path, mode, execute)
    session.do("show")
    for command in session.machine.commands():
        assert session.do(f"why {label(command.event)}").text
        for words in ("enabled", "disabled"):
            _may_fail(session, f"expect {words} {label(command.event)}")
    done = session.do("random 40 7")
    assert done.happenings or done.text
    for choice in session.machine.choices():
        assert choice.text
    assert session.script()
    session.do("undo 3")
    session.do("restart")
    if execute:
        session.do("wait 1.5")
    else:
        drawn = session.machine.draw(random.Random(3))
        assert drawn is None or session.machine.can(*drawn)  # type: ignore[misc]


@pytest.mark.parametrize("execute", [False, True], ids=["single events", "execute"])
def test_scripts(run: Run, tmp_path: Path, path: Path, mode: str, execute: bool) -> None:
    """A session that is saved is played again, with the state that it expects at its end."""
    session = _session(path, mode, execute)
    session.do("random 25 3")
    script = tmp_path / "run.sim"
    script.write_text(session.script(), encoding="utf-8")
    words = ("--script", str(script), *(["--execute"] if execute else []))
    assert "expectations met" in run("simulate", *words)[1]
    for line in run("simulate", *words, "--json")[1].splitlines():
        validate(json.loads(line), "simulate")


@pytest.mark.parametrize("execute", [False, True], ids=["single events", "execute"])
def test_pictures(path: Path, mode: str, execute: bool) -> None:
    session = _session(path, mode, execute)
    played = Played(session.machine, Hub())
    played.start()


def test_logs(run: Run, tmp_path: Path, path: Path, mode: str) -> None:
    """What a session did is a log that follows the model."""
    session = _session(path, mode, execute=True)
    happenings = [*session.machine.beginning, *session.do("random 25 5").happenings]
    logged = [h for h in happenings if h.outcome != "blocked"]  # that is told elsewhere
    lines = [
        json.dumps({"version": 1, "number": number, "time": float(number), **h.document()})
        for number, h in enumerate(logged, 1)
    ]
    log = tmp_path / "run.jsonl"
    log.write_text("\n".join(lines), encoding="utf-8")
    validate(json.loads(run("replay", str(log), "--json")[1]), "replay")
    report = tmp_path / "evidence.json"
    code, *_ = run("report", "--logs", str(log), "--output", str(report))
    if code == 0:
        validate(json.loads(report.read_text(encoding="utf-8")), "report")


def _session(path: Path, mode: str, execute: bool) -> Session:
    options = pipeline.Options(supervises=mode == "supervisor")
    robot = pipeline.load(path, options).robot
    return Session(machine_maker(pipeline.supervise(robot), execute=execute), {})


def _may_fail(session: Session, line: str) -> None:
    from robosc.simulate.faults import Failed

    try:
        session.do(line)
    except Failed as fault:
        assert str(fault)
