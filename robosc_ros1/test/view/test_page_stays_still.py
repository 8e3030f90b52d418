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

PLACES = """return [...document.querySelectorAll(".lamp, .command-name, .reasons")].map((e) => {
  const box = e.getBoundingClientRect(); return [box.x, box.y, box.height] })"""


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


def test_rows_of_commands_keep_their_places(played: Played, browser: Browser) -> None:
    """Whatever is sent, forbidden and why; also where there is more to say than there is room."""
    walk(played, browser, 10)
    places = browser.run(PLACES)
    reasons = set()
    for _ in range(40):
        walk(played, browser)
        assert browser.run(PLACES) == places
        reasons.add(browser.text("#command-list"))
    assert len(reasons) > 5


def test_reasons_that_do_not_fit_are_unfolded(played: Played, browser: Browser) -> None:
    browser.look(320, 800)
    row = "document.querySelector('[data-command=\"grab.request\"]')"
    lines = f"{row}.querySelector('.reasons')"
    browser.sees(f"{row}.dataset.is === 'forbidden'")
    cut = f"{lines}.scrollHeight > {lines}.clientHeight"
    assert browser.run(f"return {cut}")
    browser.run(f"{row}.querySelector('button').click()")
    assert not browser.run(f"return {cut}")
    assert browser.run(f"return {row}.querySelector('button').ariaExpanded") == "true"


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
