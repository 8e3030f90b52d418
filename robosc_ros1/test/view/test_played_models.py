"""A model that is played from the page: single events, and the controller as it executes."""

from __future__ import annotations

import json
import signal
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest
from ros_support import SOURCES
from runtime.schemas import validate
from view.watching import MODEL, Watcher, ask, line_follower, serving

from robosc.runtime.core.settings import Settings
from robosc.simulate.machines.event_by_event import SingleEvents
from robosc.simulate.machines.execute import Execution
from robosc.view.hub import Hub
from robosc.view.played import Played
from robosc.view.server import PageServer, Unable, Where

FREE = {"event": {"kind": "response", "name": "distance", "value": "free"}}


@pytest.fixture
def played() -> tuple[Played, Hub]:
    hub = Hub()
    return Played(SingleEvents(line_follower()), hub), hub


def latest(hub: Hub) -> dict[str, Any]:
    news: dict[str, Any] = json.loads(hub.follow().take(1) or "")
    return news


def test_an_event_is_fired_and_taken_back(played: tuple[Played, Hub]) -> None:
    source, hub = played
    source.do(FREE)
    news = latest(hub)
    assert news["state"]["components"]["DistanceSensor"] == "sensing"
    assert [e["event"] for e in news["events"]] == [FREE["event"]]
    source.do({"event": {"kind": "request", "name": "move"}})
    assert latest(hub)["events"][-1]["event"]["value"] == {
        "linear": {"x": 0.2},
        "angular": {"z": 0.0},
    }
    source.do({"undo": 2})
    assert latest(hub)["state"]["components"]["DistanceSensor"] == "waiting"
    source.do({"restart": True})
    assert "events" not in latest(hub)


def test_a_forbidden_command_names_its_requirements(played: tuple[Played, Hub]) -> None:
    _, hub = played
    commands = {c["event"]["name"]: c for c in latest(hub)["state"]["commands"]}
    fresh, reason = commands["move"]["blocked_by"]
    assert fresh["text"] == "requirement move needs distance.fresh"
    assert reason["text"] == "requirement move needs DistanceSensor.current = free"
    line = int(reason["place"].rpartition(":")[2])
    assert "move needs DistanceSensor.current = free" in MODEL.read_text().splitlines()[line - 1]


@pytest.mark.parametrize(
    ("document", "message"),
    [
        ({"event": {"kind": "request", "name": "move"}}, "move.request cannot happen now"),
        (
            {"event": {"kind": "response", "name": "distance"}, "text": "purple"},
            "free or obstructed",
        ),
        ({"event": {"kind": "response", "name": "nobody"}}, "there is no event"),
        ({"undo": 1}, "nothing to undo"),
        ({"random": 10**9}, "no such request"),
        ({"line": "save /tmp/x"}, "no such request"),
        ([1], "no such request"),
        (None, "no such request"),
    ],
)
def test_what_cannot_be_done_changes_nothing(
    played: tuple[Played, Hub], document: Any, message: str
) -> None:
    source, hub = played
    before = latest(hub)
    with pytest.raises(Unable, match=message):
        source.do(document)
    assert latest(hub) == before


def test_the_documents_are_those_of_a_running_controller(played: tuple[Played, Hub]) -> None:
    source, hub = played
    source.do({"random": 50})
    news = latest(hub)
    validate(news["model"], "model")
    for event in news["events"]:
        validate(event, "event")
    state = news["state"]
    for extra in ("marked", "choices", "undo"):
        state.pop(extra)
    for command in state["commands"]:
        command.pop("data")
    validate(state, "state")


def test_the_executing_controller_answers_by_itself_as_time_passes() -> None:
    hub = Hub()
    source = Played(Execution(line_follower(), Settings()), hub)
    source.start()
    with serving(hub, source.answers) as server:
        watcher = Watcher(server.server_port)
        watcher.until(lambda w: "state" in w.seen)
        assert ask(server, "/do", FREE)[0] == 200
        watcher.until(lambda w: w.seen["state"]["components"]["Motor"] == "moving")
        moves = [e for e in watcher.events if e["event"]["name"] == "move"]
        watcher.until(
            lambda w: sum(e["event"]["name"] == "move" for e in w.events) > len(moves) + 3
        )
        watcher.close()


@pytest.fixture
def process(tmp_path: Path) -> Iterator[subprocess.Popen[str]]:
    with subprocess.Popen(
        [sys.executable, "-m", "robosc", "view", str(MODEL), "--port", "0"],
        cwd=tmp_path,
        env={"PYTHONPATH": str(SOURCES), "PYTHONDONTWRITEBYTECODE": "1"},
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
    ) as running:
        yield running
        running.kill()


def test_the_command_prints_its_address_and_ends_when_interrupted(
    process: subprocess.Popen[str],
) -> None:
    assert process.stdout is not None and process.stderr is not None
    url = process.stdout.readline().strip()
    assert url.startswith("http://127.0.0.1:")
    port = int(url.rstrip("/").rpartition(":")[2])
    watcher = Watcher(port)
    watcher.until(lambda w: "state" in w.seen)
    process.send_signal(signal.SIGINT)  # while somebody watches
    assert process.wait(60) == 130
    assert process.stderr.read().splitlines()[-1] == "interrupted"
    watcher.close()


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        ([], "Give a MODEL"),
        ([str(MODEL), "--ros", "/node"], "leave MODEL out"),
        (["--log", "nowhere.jsonl"], "Give a MODEL"),
        ([str(MODEL), "--log", "nowhere.jsonl"], "nowhere.jsonl"),
        ([str(MODEL), "--parameter", "rate=5"], "--execute"),
        ([str(MODEL), "--port", "80000"], "not a port"),
        ([str(MODEL), "--host", "203.0.113.7"], "203.0.113.7"),
        ([str(MODEL), "--host", ""], "not an address"),
        ([str(MODEL), "--host", "ü.."], "not an address"),
        ([str(MODEL), "--host", "x" * 70], "not an address"),
    ],
)
def test_wrong_usage_is_told(robosc: Any, arguments: list[str], words: str) -> None:
    done = robosc("view", *arguments)
    assert (done.returncode, words in done.stderr) == (2, True), done.stderr


def test_the_server_serves_this_machine_only_unless_told() -> None:
    with PageServer(Where(port=0), Hub(), {}) as server:
        assert server.server_address[0] == "127.0.0.1"
