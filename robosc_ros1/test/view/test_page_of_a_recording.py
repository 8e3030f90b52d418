"""The page of an event log: searching all of it, jumping, where it leaves the model."""

from __future__ import annotations

import json
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest
from view.browser import Browser
from view.watching import BEGUN, line_follower, log_of, serving

from robosc.view.hub import Hub
from robosc.view.recorded import Recording

ENTER = "\ue007"
LENGTH = 1500
NEEDLES = [12, 700, 1200]  # places of events that are seldom
LEFT = 1400  # where the log leaves the model


def written(document: Any, number: int, **changes: Any) -> str:
    return json.dumps({**document, "number": number, **changes})


@pytest.fixture(scope="module")
def log(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A run that is longer than what a page has of it at a time."""
    free, obstructed = (("distance", "response", value) for value in ("free", "obstructed"))
    steps: list[Any] = [free, 0.25, obstructed, 0.15] * 300
    documents = [json.loads(line) for line in log_of(line_follower(), *steps)]
    mismatch = {
        "version": 1, "event": {"kind": "response", "name": "grab", "value": None},
        "outcome": "mismatch", "detail": "needle: it is idle",
    }  # fmt: skip
    departure = {
        "version": 1, "event": {"kind": "request", "name": "grab", "value": None},
        "outcome": "applied", "detail": None,
    }  # fmt: skip
    for place in NEEDLES:
        documents.insert(place - 1, {**mismatch, "time": documents[place - 1]["time"]})
    documents.insert(LEFT - 1, {**departure, "time": documents[LEFT - 1]["time"]})
    path = tmp_path_factory.mktemp("log") / "events.jsonl"
    lines = [written(document, number) for number, document in enumerate(documents[:LENGTH], 1)]
    path.write_text("\n".join(lines), encoding="utf-8")
    return path


@pytest.fixture
def url(log: Path, browser: Browser) -> Iterator[str]:
    """The page of that log is open."""
    hub = Hub()
    with serving(hub, Recording(line_follower(), str(log), hub).answers) as server:
        browser.open(server.url)
        browser.sees("recording.at === 1 && page.shown")
        yield server.url


def at(place: int) -> str:
    return f"recording.at === {place} && page.shown"


def test_a_search_finds_all_and_leads_through_it(url: str, browser: Browser) -> None:
    browser.press("/NEEDLE")
    found = "document.getElementById('found').textContent"
    browser.sees(f"{found} === '3 hits'")
    for number, place in enumerate(NEEDLES, 1):
        browser.press(ENTER)
        browser.sees(f"{at(place)} && {found} === '{number} of 3 hits'")
        rows = "[...document.querySelectorAll('#events li')].map((e) => Number(e.dataset.place)).join()"
        browser.sees(f"{rows} === '{','.join(map(str, NEEDLES[:number][::-1]))}'")
    browser.run("document.getElementById('previous').click()")
    browser.sees(at(NEEDLES[1]))
    browser.run("document.querySelector('#events li:last-child').click()")
    browser.sees(at(NEEDLES[0]))
    browser.run("document.getElementById('filter').value = ''; filter()")
    browser.sees(f"document.getElementById('events').childElementCount === {NEEDLES[0]}")


@pytest.mark.parametrize(("text", "word"), [("777", "number"), ("17:0", "time")])
def test_a_jump_by_number_and_by_time(text: str, word: str, url: str, browser: Browser) -> None:
    offset = browser.run(f"return new Date({BEGUN} * 1000).getTimezoneOffset()") * 60
    if word == "time":
        seconds = (BEGUN - offset) % 86400 + 60.0
        hours, minutes, rest = seconds // 3600, seconds // 60 % 60, seconds % 60
        text = f"{hours:02.0f}:{minutes:02.0f}:{rest:06.3f}"
    field = "document.getElementById('goto')"
    browser.run(f"{field}.value = arguments[0]; {field}.dispatchEvent(new Event('change'))", text)
    if word == "number":
        browser.sees(at(777))
    else:
        browser.sees(f"recording.at > 1 && recording.times[recording.at - 1] >= {BEGUN + 60}")
        assert browser.run(f"return recording.times[recording.at - 2] < {BEGUN + 60}")
    browser.run(f"{field}.value = 'soon'; {field}.dispatchEvent(new Event('change'))")
    assert not browser.run(f"return {field}.checkValidity()")


def test_where_the_log_leaves_the_model_is_seen_and_reached(url: str, browser: Browser) -> None:
    button = "document.getElementById('departure')"
    browser.sees(f"{button}.textContent === 'Leaves the model at event {LEFT}'")
    assert browser.run("return document.getElementById('lost').hidden")
    browser.run(f"{button}.click()")
    browser.sees(at(LEFT))
    browser.sees(f"document.getElementById('lost').textContent.includes('event {LEFT}: ')")
    row = f"document.querySelector('[data-place=\"{LEFT}\"]')"
    browser.sees(f"{row}.textContent.includes('Event {LEFT} leaves the model: ')")
    browser.run("recording.go(arguments[0])", LEFT + 5)
    browser.sees(at(LEFT + 5))
    beyond = "document.querySelectorAll('#events .beyond').length"
    browser.sees(f"{beyond} === 6")  # in another colour than those before
    browser.run("recording.go(arguments[0])", LEFT - 1)
    browser.sees(f"{at(LEFT - 1)} && {beyond} === 0")
    assert browser.run("return document.getElementById('lost').hidden")


def test_a_link_leads_to_what_was_looked_at(url: str, browser: Browser) -> None:
    browser.press("/needle")
    browser.run("recording.go(123)")
    browser.sees("location.hash === '#at=123&filter=needle'")
    link = browser.run("return location.href")
    browser.open("about:blank")
    browser.open(link)
    browser.sees(at(123))
    browser.sees("document.getElementById('found').textContent === '3 hits'")


def test_lanes_have_every_event_of_their_seconds(url: str, browser: Browser) -> None:
    browser.run("recording.go(1300)")
    browser.sees(at(1300))
    browser.sees("page.times.latest === recording.times[1299]")
    shown = browser.run("return page.times.ticks.map((t) => t.place)")
    times = browser.run("return recording.times")
    within = [p for p, time in enumerate(times, 1) if p <= 1300 and time > times[1299] - 20]
    assert shown == within


def test_lanes_of_a_thousand_events_per_second(browser: Browser) -> None:
    """Twenty seconds of 1,280 events per second: rates are right, and there is no blank."""
    hub = Hub()
    with serving(hub) as server:
        browser.open(server.url)
        browser.sees("page.times")
        browser.run(
            "window.begin = 1e9;"
            "for (let i = 0; i < 20 * 1280; i++) page.times.tick(begin + i / 1280,"
            " {event: {kind: 'response', name: i % 4 ? 'scan' : 'pose', value: null}, outcome: 'applied'});"
        )
        lanes = browser.run("return page.times.lanes(begin + 20, () => true).lanes")
        assert [(lane["name"], round(lane["rate"])) for lane in lanes] == [
            ("pose", 320), ("scan", 960),
        ]  # fmt: skip
        blanks = browser.run(
            "const canvas = document.getElementById('lanes');"
            "const colours = {'--robot': '#ff0000', '--ink': '#0000ff', '--quiet': '#0000ff'};"
            "page.times.drawLanes(canvas, begin + 20, colours, () => true);"
            "const {width} = canvas, row = canvas.getContext('2d').getImageData(0, 4, width, 1).data;"
            "const red = [...Array(width).keys()].filter((x) => row[4 * x] === 255 && row[4 * x + 1] === 0);"
            "return [red.length, red.at(-1) - red[0] + 1, width]"
        )
        assert blanks[0] == blanks[1] > blanks[2] / 2
