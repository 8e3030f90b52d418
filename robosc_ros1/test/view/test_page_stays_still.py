"""While events rush, nothing moves under the pointer, and no click is lost."""

from __future__ import annotations

from collections.abc import Iterator

import pytest
from view.browser import Browser
from view.watching import is_in, line_follower, serving

from robosc.simulate.machines.event_by_event import SingleEvents
from robosc.view.hub import Hub
from robosc.view.played import Played

DOWN, UP = ({"type": kind, "button": 0} for kind in ("pointerDown", "pointerUp"))


@pytest.fixture
def played(browser: Browser) -> Iterator[Played]:
    """A line follower whose page is open."""
    hub = Hub()
    played = Played(SingleEvents(line_follower()), hub)
    with serving(hub, played.answers) as server:
        browser.open(server.url)
        browser.sees("page.choices.length")
        yield played


def walk(played: Played, browser: Browser, steps: int = 1) -> None:
    """Take steps at random, and wait until the page shows them."""
    for _ in range(steps):
        played.do({"random": 1})
    browser.sees("page.shown.number === arguments[0]", played._number)


def test_no_click_is_lost_while_events_come(played: Played, browser: Browser) -> None:
    browser.run(
        "window.posted = []; const before = fetch;"
        "window.fetch = (...all) => { posted.push(JSON.parse(all[1].body)); return before(...all) }"
    )
    for clicks in range(1, 9):
        # Each press lasts for three states, between which choices come and go.
        browser.mouse(browser.middle('[data-choice="distance.response(free)"]'), DOWN)
        walk(played, browser, 3)
        browser.mouse(UP)
        browser.sees("posted.length === arguments[0]", clicks)
    fired = browser.run("return posted.map((p) => [p.event.name, p.event.value])")
    assert fired == [["distance", "free"]] * 8


def test_what_is_not_possible_any_more_says_so(played: Played, browser: Browser) -> None:
    for kind, state in (("request", "switching"), ("response", "known")):
        played.do({"event": {"kind": kind, "name": "set_light_state"}})
        browser.sees(is_in("LightBulb", state))
    choice = '[data-choice="set_light_state.response"]'
    assert browser.run(f"return document.querySelector('{choice}').ariaDisabled") == "true"
    browser.mouse(browser.middle(choice), DOWN, UP)
    browser.sees("document.getElementById('refused').textContent.includes('set_light_state')")
    browser.complaints()  # the browser tells of every answer that is no success


ROW = "document.querySelector('[data-command=\"move.request\"]')"


def test_all_reasons_are_there_at_any_width(played: Played, browser: Browser) -> None:
    browser.look(320, 800)
    browser.sees(f"{ROW}.dataset.is === 'forbidden'")
    lines = f"{ROW}.querySelector('.reasons')"
    assert browser.run(f"return {lines}.scrollHeight <= {lines}.clientHeight")
    text = browser.run(f"return {lines}.innerText")
    assert "requirement move needs" in text and "…" not in text


def test_a_row_keeps_its_height_for_a_moment_and_then_has_no_empty_lines(
    played: Played, browser: Browser
) -> None:
    """A command that is enabled and disabled several times a second does not move the others."""
    height = f"{ROW}.offsetHeight"
    browser.sees(f"{ROW}.dataset.is === 'forbidden'")
    before = browser.run(f"return {height}")
    for name, value in (("distance", "free"), ("correction", 3.0)):
        played.do({"event": {"kind": "response", "name": name, "value": value}})
    browser.sees(f"{ROW}.dataset.is === 'enabled'")
    assert browser.run(f"return {height}") >= before
    browser.sees(f"{height} < arguments[0]", before)
    assert browser.run(f"return {ROW}.querySelector('.reasons').offsetHeight") == 0


def test_what_is_empty_takes_no_room(played: Played, browser: Browser) -> None:
    height = "document.getElementById(arguments[0]).offsetHeight"
    for name in ("timeline", "refused"):
        browser.sees(f"{height} === 0", name)
    walk(played, browser, 1)
    browser.sees(f"{height} > 0", "timeline")


@pytest.mark.parametrize("width", [320, 360, 390, 768, 1000, 1280])
def test_counters_are_not_cut_and_stay_where_they_are(
    width: int, played: Played, browser: Browser
) -> None:
    browser.look(width, 800)
    places = (
        "return [...document.querySelectorAll('#gauges div')]"
        ".map((e) => [e.offsetLeft, e.offsetTop])"
    )
    browser.sees("document.querySelectorAll('#gauges div').length")
    before = browser.run(places)
    walk(played, browser, 30)
    if width < 1100:
        assert browser.run(places) == before
    else:
        assert len({top for _, top in browser.run(places)}) == 1
    gauges = "document.getElementById('gauges')"
    assert browser.run(f"return {gauges}.scrollWidth <= {gauges}.clientWidth")
    assert browser.run("return document.documentElement.scrollWidth <= innerWidth")
