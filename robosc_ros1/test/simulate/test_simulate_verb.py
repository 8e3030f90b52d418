"""``robosc simulate``: scripts as regression tests, JSON for programs, lines on standard input."""

from __future__ import annotations

import io
import json
import random
import re
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path
from typing import Any
from xml.etree import ElementTree

import pytest
from cli import models
from emit.generated_code import supervisor_of
from hypothesis import given, settings
from hypothesis import strategies as st
from random_models import random_model
from ros_support import REPOSITORY, SOURCES, Completed
from runtime.schemas import validate
from simulate.players import MODEL, SEVERAL_TYPES, session

from robosc.runtime.core.telemetry import dump
from robosc.simulate.script.documents import done_document

Robosc = Callable[..., Completed]

DOCUMENT = (REPOSITORY / "docs" / "simulate.md").read_text()
SCRIPTS = re.findall(r"^```sim *(--execute)?\n(.*?)^```", DOCUMENT, re.MULTILINE | re.DOTALL)


@pytest.fixture
def simulate(robosc: Robosc, tmp_path: Path) -> Callable[..., Completed]:
    """Runs a script over the line follower."""

    def run(script: str, *options: str) -> Completed:
        (tmp_path / "run.sim").write_text(script)
        return robosc("simulate", str(MODEL), "--script", "run.sim", *options)

    return run


@pytest.fixture
def typed(robosc: Robosc, monkeypatch: pytest.MonkeyPatch) -> Callable[..., Completed]:
    """Runs with lines on standard input."""

    def run(text: str, *options: str) -> Completed:
        monkeypatch.setattr(sys, "stdin", io.StringIO(text))
        return robosc("simulate", str(MODEL), *options)

    return run


def test_a_script_is_told_as_junit(simulate, tmp_path: Path) -> None:
    """What was not met is a failure; what ends the script is an error, and nothing comes behind."""
    script = "expect Motor.moving\nexpect Motor.stopped # <&\x1b\ndistance free\nnonsense\nexpect x"
    done = simulate(script, "--junit", "found.xml")
    assert done.returncode == 2, done.stderr
    text = (tmp_path / "found.xml").read_text(encoding="utf-8")
    suite = ElementTree.fromstring(text)
    assert suite.attrib == {"name": "run.sim", "tests": "3", "failures": "1", "errors": "1"}
    cases = [(c.get("name"), c.get("line"), [part.tag for part in c]) for c in suite]
    assert cases == [
        ("line 1: expect Motor.moving", "1", []),
        ("line 2: expect Motor.stopped # <&\N{REPLACEMENT CHARACTER}", "2", ["failure"]),
        ("line 4: nonsense", "4", ["error"]),
    ]
    (failure,) = suite.iter("failure")
    assert "Motor is in moving" in (failure.text or "")


def test_junit_without_a_script_is_a_mistake(typed) -> None:
    done = typed("", "--junit", "found.xml")
    assert (done.returncode, "--script FILE" in done.stderr) == (2, True)


def test_the_document_has_scripts() -> None:
    assert {options for options, _ in SCRIPTS} == {"", "--execute"}


@pytest.mark.parametrize(("options", "script"), SCRIPTS)
def test_scripts_of_the_document(options: str, script: str, simulate) -> None:
    done = simulate(script, *options.split())
    assert (done.returncode, done.stderr) == (0, "")
    count = len(re.findall(r"^expect", script, re.MULTILINE))
    assert done.stdout == f"run.sim: {count} of {count} expectations met\n"


def test_the_first_picture_of_the_document(typed) -> None:
    done = typed("quit\n")
    shown = re.search(r"^\$ robosc simulate line_follower.rscd\n(.*?)^>$", DOCUMENT,
                      re.MULTILINE | re.DOTALL)  # fmt: skip
    assert shown is not None
    assert done.stdout == shown.group(1)


def test_failed_expectations_are_told_and_the_rest_is_done(simulate) -> None:
    done = simulate(
        "distance 0.2\nexpect Motor.stopped\n\nexpect disabled stop\nexpect Motor.moving"
    )
    assert done.returncode == 1
    assert done.stderr.splitlines() == [
        "run.sim:2: failed: Motor.stopped does not hold: Motor is in moving",
        "run.sim:4: failed: stop.request is enabled",
    ]
    assert done.stdout == "run.sim: 1 of 3 expectations met\n"


def test_an_event_that_cannot_happen_ends_the_script(simulate) -> None:
    done = simulate("move\nexpect Motor.flying\n")
    assert done.returncode == 1
    assert done.stderr.startswith("run.sim:1: refused: move.request cannot happen now: requirement")
    assert done.stderr.count("\n") == 1


@pytest.mark.parametrize("line", ["mvoe", "3", "expect Motor.flying", "distance", "wait 1"])
def test_wrong_lines_are_told_with_their_place(simulate, line: str) -> None:
    done = simulate(f"# comment\n{line}\nexpect Motor.stopped\n")
    assert done.returncode == 2
    assert done.stderr.startswith("run.sim:2: wrong: ")


def test_expectations_about_what_was_sent(simulate) -> None:
    script = (
        "distance free\nexpect sent stop\nexpect sent nothing\nwait 0.3\nexpect sent move * 2\n"
        "expect data move linear.x: 0.5\nexpect data move linear.y: 0.5\nexpect data stop 3\n"
    )
    done = simulate(script, "--execute")
    assert done.returncode == 1
    assert done.stderr.splitlines() == [
        "run.sim:2: failed: sent: move.request; expected: stop.request",
        "run.sim:3: failed: sent: move.request; expected: nothing",
        "run.sim:5: failed: sent: move.request * 3; expected: move.request * 2",
        "run.sim:6: failed: linear.x was 0.2, not 0.5",
        "run.sim:7: failed: linear.y was not sent; sent were linear.x, angular.z",
        "run.sim:8: failed: stop.request was not sent",
    ]


def test_scripts_that_play_each_other_for_ever(simulate) -> None:
    done = simulate("play run.sim\n")
    assert done.returncode == 2
    assert "levels deep" in done.stderr


@pytest.mark.parametrize(
    "options",
    [
        ("--script", "nowhere.sim"),
        ("--script", "."),
        ("--parameter", "rate=5"),
        ("--execute", "--parameter", "rate"),
        ("--execute", "--parameter", "rate=quick"),
        ("--execute", "--parameter", "rte=5"),
    ],
    ids=" ".join,
)
def test_wrong_usage(options: tuple[str, ...], robosc: Robosc) -> None:
    done = robosc("simulate", str(MODEL), *options)
    assert done.returncode == 2
    assert done.stderr.startswith("error: ")
    assert done.stdout == ""


def test_models_that_cannot_be_played(robosc: Robosc, tmp_path: Path) -> None:
    for text, code in ((models.WITH_ERRORS, 1), (models.LIBRARY, 2), (models.EMPTY_SUPERVISOR, 3)):
        (tmp_path / "model.rscd").write_text(text)
        assert robosc("simulate", "model.rscd").returncode == code


def test_lines_on_standard_input_need_no_terminal(typed) -> None:
    done = typed("dist free\nnonsense\nmove\nhelp\nwhy grab.cancel")
    assert done.returncode == 0
    assert "\x1b" not in done.stdout
    assert "Motor            moving" in done.stdout
    assert "there is no event or command 'nonsense'" in done.stdout
    assert "! move.request {linear: {x: 0.2}, angular: {z: 0.0}}" in done.stdout
    assert "goto CONDITION" in done.stdout
    assert "grab.cancel\n  now: it is idle\n  allowed where " in done.stdout


def documents(done: Completed) -> list[dict[str, Any]]:
    """What was written, each as its schema says."""
    found = [json.loads(line) for line in done.stdout.splitlines()]
    for document in found:
        validate(document, "simulate")
    return found


def test_json_answers_each_document(typed) -> None:
    asked = [
        {"line": "correction 5", "id": "a"},
        {"event": {"kind": "response", "name": "distance", "value": 0.9}, "id": 2},
        "move",
        {"event": {"kind": "response", "name": "distance", "value": {"x": 1}}},
        {"event": {"kind": "cancel", "name": "grab"}, "id": 3},
    ]
    for request in asked:
        validate(request, "simulate-request")
    asked += [{"nothing": 0}, []]
    text = "\n".join(json.dumps(document) for document in asked) + "\n{\n"
    done = typed(text, "--json")
    found = documents(done)
    assert done.returncode == 0
    assert [(d["line"], d["ok"], d.get("id")) for d in found] == [
        (0, True, None), (1, True, "a"), (2, True, 2), (3, True, None),
        (4, False, None), (5, False, 3), (6, False, None), (7, False, None), (8, False, None),
    ]  # fmt: skip
    assert [d["fault"] for d in found[4:]] == ["wrong", "refused", "wrong", "wrong", "wrong"]
    assert found[2]["happened"] == [
        {"event": {"kind": "response", "name": "distance", "value": "free"},
         "outcome": "applied", "detail": None}
    ]  # fmt: skip
    assert found[3]["happened"][0]["event"]["value"] == {
        "linear": {"x": 0.4}, "angular": {"z": 0.05}
    }  # fmt: skip
    assert found[3]["state"]["components"]["Motor"] == "moving"
    move = found[0]["commands"][0]
    assert move["event"] == {"kind": "request", "name": "move"}
    assert not move["enabled"]
    assert move["blocked_by"][0]["kind"] == "requirement"
    assert re.fullmatch(r"line_follower\.rscd:\d+", move["blocked_by"][0]["place"])


def test_documents_of_programs_name_events_in_full(typed) -> None:
    text = "".join(
        json.dumps({"event": {"kind": "response", "name": name, "value": 1.0}}) + "\n"
        for name in ("", "dist", "distance ", "distance")
    )
    assert [d["ok"] for d in documents(typed(text, "--json"))] == [True, False, False, False, True]


@pytest.mark.slow
@settings(max_examples=25)
@given(seed=st.integers(0, 10**6), execute=st.booleans())
def test_every_answer_follows_the_schema(seed: int, execute: bool) -> None:
    """In any state of any model."""
    texts = (random_model(random.Random(seed), 1 + seed % 3), SEVERAL_TYPES)
    supervisor = supervisor_of(texts[seed % 2])
    if supervisor.empty:
        return
    player = session(supervisor, execute=execute)
    for number in range(5):
        done = player.do(f"random 4 {number}")
        validate(json.loads(dump(done_document(player, number, done, {"any": [seed]}))), "simulate")


def test_every_choice_with_a_value_can_be_fired_as_it_stands(typed) -> None:
    (begin,) = documents(typed("", "--json"))
    choices = [c["event"] for c in begin["choices"] if c["needs"] is None]
    assert len(choices) == 5
    for event in choices:
        answer = documents(typed(json.dumps({"event": {**event}}) + "\n", "--json"))[1]
        assert answer["ok"]


def test_json_of_an_execution_has_the_clock(typed) -> None:
    found = documents(typed('"distance free"\n"wait 0.1"\n', "--json", "--execute"))
    assert found[0]["happened"][0]["event"]["name"] == "stop"
    assert found[2]["state"]["time"] == 0.1
    assert found[2]["happened"][0]["time"] == 0.1
    assert found[2]["commands"][0]["count"] == 2


def test_json_of_an_execution_has_the_reasons_of_errors(typed) -> None:
    """Also of those that the model does not read, and that come by the clock alone."""
    found = documents(typed('"set_light_state.error"\n"wait 6"\n', "--json", "--execute"))
    told = [
        (h["detail"], h.get("reason"))
        for answer in found
        for h in answer["happened"]
        if h["event"]["kind"] == "error"
    ]
    assert told == [("simulated", "failed"), ("no answer in time", "timeout")]
    for answer in found:
        validate(answer, "simulate")


def test_a_failed_expectation_is_an_answer_and_an_exit_code(typed, simulate) -> None:
    done = typed('"expect Motor.stopped"\n"expect Motor.moving"\n', "--json")
    assert done.returncode == 1
    assert [d["ok"] for d in documents(done)] == [True, False, True]
    done = simulate("expect Motor.stopped\nexpect Motor.moving\n", "--json")
    assert [d["ok"] for d in documents(done)] == [True, False, True]
    assert done.returncode == 1


def test_the_same_script_gives_the_same_answers(simulate) -> None:
    script = "random 60 5\nwait 3\nrandom 20\n"
    assert simulate(script, "--json", "--execute").stdout == (
        simulate(script, "--json", "--execute").stdout
    )


def test_another_program_gets_each_answer_at_once() -> None:
    """It waits for an answer before it asks on."""
    process = subprocess.Popen(
        [sys.executable, "-m", "robosc", "simulate", str(MODEL), "--json"],
        env={"PYTHONPATH": str(SOURCES), "PATH": "/usr/bin:/bin"},
        stdin=subprocess.PIPE,
        stdout=subprocess.PIPE,
        text=True,
    )
    assert process.stdin is not None and process.stdout is not None
    assert json.loads(process.stdout.readline())["line"] == 0
    for number in range(1, 4):
        process.stdin.write('"distance free"\n')
        process.stdin.flush()
        assert json.loads(process.stdout.readline())["line"] == number
    process.stdin.close()
    assert process.wait(timeout=600) == 0
    process.stdout.close()
