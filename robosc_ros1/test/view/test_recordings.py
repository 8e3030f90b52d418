"""Event logs, and the state at each moment of them."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import pytest
from runtime.schemas import validate
from view.watching import line_follower, log_of

from robosc.errors import UsageError
from robosc.simulate.event_log import read_log
from robosc.simulate.replay import Follower
from robosc.view.hub import Hub
from robosc.view.recorded import Recording
from robosc.view.server import Unable

FREE = ("distance", "response", "free")
OBSTRUCTED = ("distance", "response", "obstructed")
NOT_A_NUMBER = (
    '{"version": 1, "number": 1, "time": 1.0, "outcome": "applied", "detail": null,'
    ' "event": {"kind": "response", "name": "correction", "value": NaN}}'
)
"""No JSON, of which a browser could show nothing; a node writes a text instead."""


@pytest.fixture(scope="module")
def long_run() -> str:
    """Some hundred events: more than are kept between two moments."""
    return "\n".join(log_of(line_follower(), *[FREE, 0.25, OBSTRUCTED, 0.15] * 120)) + "\n"


@pytest.fixture
def log(tmp_path: Path, long_run: str) -> Path:
    path = tmp_path / "events.jsonl"
    path.write_text(long_run, encoding="utf-8")
    return path


def test_every_moment_has_the_state_that_the_events_led_to(log: Path) -> None:
    supervisor = line_follower()
    recording = Recording(supervisor, str(log), Hub())
    follower = Follower(supervisor)
    entries = list(read_log(str(log)))
    assert len(entries) > 600
    counted = 0
    for at, entry in enumerate(entries, 1):
        follower.take(entry)
        counted += (entry.name, entry.kind) == ("stop", "request")
        if at % 7 and at < len(entries):
            continue
        moment = recording.moment({"at": at})
        controller = follower.controller
        assert controller is not None
        assert moment["state"]["components"] == controller.components()
        assert moment["state"]["variables"] == controller.variables()
        assert moment["events"][-1] == entry.document
        (stop,) = (c for c in moment["state"]["commands"] if c["event"]["name"] == "stop")
        assert stop["count"] == counted


def test_documents_follow_their_schemas(log: Path) -> None:
    hub = Hub()
    recording = Recording(line_follower(), str(log), hub)
    news = json.loads(hub.follow().take(1) or "")
    validate(news["model"], "model")
    moment = recording.moment({"at": 300})
    validate(moment["state"], "state")
    overview = recording.overview({})
    assert len(overview["times"]) == len(overview["sorts"]) == news["hello"]["count"]
    assert set(overview["sorts"]) == {"c", "r"}
    first = [json.loads(line)["event"]["name"] for line in log.read_text().splitlines()[:5]]
    assert [overview["names"][n] for n in overview["name"][:5]] == first
    assert overview["departures"] == []


def test_where_a_log_leaves_the_model_the_last_state_stays(tmp_path: Path) -> None:
    lines = log_of(line_follower(), FREE, 0.2)
    forbidden = {
        "version": 1, "number": len(lines) + 1, "time": 9e9, "outcome": "applied", "detail": None,
        "event": {"kind": "request", "name": "grab", "value": None},
    }  # fmt: skip
    late = forbidden | {
        "number": len(lines) + 2,
        "event": {"kind": "error", "name": "grab", "value": None},
    }
    path = tmp_path / "wrong.jsonl"
    path.write_text("\n".join([*lines, json.dumps(forbidden), json.dumps(late)]), encoding="utf-8")
    recording = Recording(line_follower(), str(path), Hub())
    (departure,) = recording.overview({})["departures"]
    reason = departure.pop("reason")
    assert "disables grab" in reason
    assert departure == {"at": len(lines) + 1, "until": len(lines) + 2}
    good = recording.moment({"at": len(lines)})
    for at in (len(lines) + 1, len(lines) + 2):
        bad = recording.moment({"at": at})
        assert bad["state"]["components"] == good["state"]["components"]


def test_a_first_event_that_leaves_the_model_leaves_the_initial_state(tmp_path: Path) -> None:
    grab = {"kind": "request", "name": "grab", "value": None}
    line = {
        "version": 1,
        "number": 1,
        "time": 9.0,
        "outcome": "applied",
        "detail": None,
        "event": grab,
    }
    path = tmp_path / "wrong.jsonl"
    path.write_text(json.dumps(line), encoding="utf-8")
    recording = Recording(line_follower(), str(path), Hub())
    assert [d["at"] for d in recording.overview({})["departures"]] == [1]
    initial = recording.moment({"at": 1})["state"]
    assert initial["components"]["DistanceSensor"] == "waiting"
    assert list(recording.states()) == [initial]


def test_a_departure_ends_with_its_run(tmp_path: Path) -> None:
    run = log_of(line_follower(), FREE, 0.3)
    gap = [*run[:2], *run[3:]]
    path = tmp_path / "runs.jsonl"
    path.write_text("\n".join([*gap, *run, *gap]), encoding="utf-8")
    departures = Recording(line_follower(), str(path), Hub()).overview({})["departures"]
    found = [(d["at"], d["until"], "are missing" in d["reason"]) for d in departures]
    second = len(gap) + len(run)
    assert found == [(3, len(gap), True), (second + 3, second + len(gap), True)]


def test_each_run_has_its_own_reason_to_be_lost(tmp_path: Path) -> None:
    run = log_of(line_follower(), FREE, 0.3)
    stray = json.loads(run[-1]) | {"event": {"kind": "error", "name": "grab", "value": None}}
    path = tmp_path / "runs.jsonl"
    path.write_text("\n".join([*run[:-1], json.dumps(stray), *run[:2], *run[3:]]), encoding="utf-8")
    departures = Recording(line_follower(), str(path), Hub()).overview({})["departures"]
    assert ["are missing" in d["reason"] for d in departures] == [False, True]


def test_the_whole_log_is_searched(log: Path) -> None:
    recording = Recording(line_follower(), str(log), Hub())
    documents = [json.loads(line) for line in log.read_text(encoding="utf-8").splitlines()]
    for text, name, value in (
        ("Obstructed", "distance", "obstructed"),
        ("move.request {linear: {x: 0.2}, angular: {z: 0", "move", None),
        ("nothing like it", "", None),
    ):
        hits = recording.search({"text": text})["hits"]
        assert hits == [
            place
            for place, document in enumerate(documents, 1)
            if document["event"]["name"] == name and value in (None, document["event"]["value"])
        ]
        found = recording.events({"places": hits[-5:]})["events"]
        assert found == [documents[place - 1] for place in hits[-5:]]


@pytest.mark.parametrize("document", [{"text": 1}, {}, None, []])
def test_what_is_no_text_is_not_searched_for(log: Path, document: Any) -> None:
    with pytest.raises(Unable, match="no text"):
        Recording(line_follower(), str(log), Hub()).search(document)


def test_a_second_run_begins_anew(tmp_path: Path) -> None:
    run = log_of(line_follower(), FREE, 0.3)
    path = tmp_path / "two.jsonl"
    path.write_text("\n".join(run + run), encoding="utf-8")
    recording = Recording(line_follower(), str(path), Hub())
    first, second = (recording.moment({"at": n * len(run)})["state"] for n in (1, 2))
    assert first == second


@pytest.mark.parametrize("document", [{"at": 0}, {"at": 10**9}, {"at": "1"}, {}, None, [1]])
def test_moments_outside_the_log_are_refused(log: Path, document: Any) -> None:
    with pytest.raises(Unable, match="events 1 to"):
        Recording(line_follower(), str(log), Hub()).moment(document)
    with pytest.raises(Unable, match="events 1 to"):
        Recording(line_follower(), str(log), Hub()).events({"places": [1, document]})


@pytest.mark.parametrize("text", ["", "no log\n", '{"version": 1}\n', NOT_A_NUMBER])
def test_what_is_no_log_is_told(tmp_path: Path, text: str) -> None:
    path = tmp_path / "faulty.jsonl"
    path.write_text(text, encoding="utf-8")
    with pytest.raises(UsageError, match=r"faulty\.jsonl"):
        Recording(line_follower(), str(path), Hub())
