"""A recording as one HTML file: the same as is served, without a server and without a network."""

from __future__ import annotations

import base64
import gzip
import json
from pathlib import Path
from typing import Any

import pytest
from view.browser import Browser
from view.watching import MODEL, is_in, line_follower, log_of

from robosc.cli import main
from robosc.view.exported import html_of
from robosc.view.hub import Hub
from robosc.view.recorded import Recording

FREE = ("distance", "response", "free")
OBSTRUCTED = ("distance", "response", "obstructed")


@pytest.fixture(scope="module")
def log(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A part of a run whose beginning is lost, a whole run, and one that leaves the model."""
    steps: list[Any] = [FREE, 0.25, ("correction", "response", 12.5), OBSTRUCTED, 0.15] * 180
    run = log_of(line_follower(), *steps)
    stray = json.loads(run[-1])
    stray |= {"number": len(run) + 1, "event": {"kind": "error", "name": "grab", "value": None}}
    stray["detail"] = "</script><!-- is not the end"
    path = tmp_path_factory.mktemp("log") / "events.jsonl"
    path.write_text("\n".join([*run[5:9], *run, json.dumps(stray)]) + "\n", encoding="utf-8")
    return path


def test_the_file_shows_what_the_server_does(log: Path, tmp_path: Path, browser: Browser) -> None:
    recording = Recording(line_follower(), str(log), Hub())
    count = recording.hello["count"]
    assert count > 1024  # more than between two states that the page keeps
    html = tmp_path / "run.html"
    assert main(["view", str(MODEL), "--log", str(log), "--export", str(html)]) == 0
    browser.open(f"{html.as_uri()}#at=7")
    browser.sees("recording.at === 7")
    places = [1, 4, 5, 6, 7, 300, 1023, 1024, 1025, 1026, count - 1, count]
    told = browser.run("return arguments[0].map((at) => exported.moment({at}))", places)
    for place, moment in zip(places, told, strict=True):
        assert moment == recording.moment({"at": place}), place
    assert browser.run("return exported.overview()") == recording.overview({})
    for text in ("OBSTRUCTED", "x: 0.2", "is not the end"):
        hits = browser.run("return exported.search({text: arguments[0]})", text)
        assert hits == recording.search({"text": text})
        assert hits["hits"]
    browser.run("return recording.go(arguments[0])", count - 1)
    state = recording.moment({"at": count - 1})["state"]
    for component, where in state["components"].items():
        browser.sees(is_in(component, where))
    browser.run("document.getElementById('departure').click()")
    browser.sees("document.getElementById('lost').textContent.includes('event 1: ')")
    assert "server" not in browser.text("#link")


def test_the_file_needs_nothing_else_and_is_always_the_same(log: Path) -> None:
    html = html_of(Recording(line_follower(), str(log), Hub()))
    assert html == html_of(Recording(line_follower(), str(log), Hub()))
    assert "<script src" not in html
    assert '<link rel="stylesheet"' not in html
    assert html.count("</script>") == 2
    assert "default-src 'none'" in html


def test_half_of_a_surrogate_pair_is_exported(log: Path, tmp_path: Path) -> None:
    path = tmp_path / "events.jsonl"
    path.write_text(log.read_text(encoding="utf-8").replace("is not the end", r"\ud800"))
    html = html_of(Recording(line_follower(), str(path), Hub()))
    packed = html.partition('id="recorded" type="text/plain">')[2].partition("<")[0]
    assert rb"\ud800" in gzip.decompress(base64.b64decode(packed))


def test_an_export_is_of_a_log(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["view", str(MODEL), "--export", str(tmp_path / "run.html")]) == 2
    assert "--log FILE" in capsys.readouterr().err
