"""A picture that is not live any more must not look as if it were."""

from __future__ import annotations

import json
from typing import Any

from ros_support import await_condition
from view.browser import Browser
from view.watching import Told, is_in, line_follower, link_says, serving

from robosc.view.hub import Hub
from robosc.view.listening import Heard

STALE = "document.body.classList.contains('stale')"
WORDS = "document.getElementById('stale').textContent"


def test_silence_is_told_until_the_node_is_heard_again(browser: Browser) -> None:
    hub = Hub()
    heard = Heard("/node", hub, silent=1.0)
    heard.watch()
    told = Told(line_follower())
    with serving(hub) as server:
        browser.open(server.url)
        browser.sees(link_says("waiting for /node"))
        browser.sees("document.getElementById('empty').textContent.includes('waiting for /node')")
        assert not browser.run(f"return {STALE}")
        goes_on(told, heard, browser, link_says("live"))
        browser.sees("document.getElementById('empty').hidden")
        # It says of when the picture is: the state's own time.
        when = browser.run("return clock(arguments[0])", told.state["time"])
        said = f"No data since {when}: waiting for /node. Everything below is as it was then."
        browser.sees(f"{STALE} && {WORDS} === arguments[0]", said)
        browser.picture("view-out-of-date")
        told.step()
        goes_on(told, heard, browser, f"!{STALE} && document.getElementById('stale').hidden")


def goes_on(told: Told, heard: Heard, browser: Browser, until: str) -> None:
    """The node tells its state, as it does each second, until the page has noticed."""

    def noticed() -> Any:
        told.to(heard)
        return browser.run(f"return {until}")

    await_condition(noticed, until)


def test_a_server_that_is_gone_is_told(browser: Browser) -> None:
    hub = Hub()
    heard = Heard("/node", hub)
    with serving(hub) as server:
        Told(line_follower()).to(heard)
        browser.open(server.url)
        browser.sees(link_says("live"))
        # As when a cable is pulled: nothing comes any more, not even the end.
        browser.run("link.stream.onmessage = null; page.heard -= BROKEN - 500")
        browser.sees(f"{STALE} && {WORDS}.includes('the server is gone')")
        assert browser.text("#link") == "the server is gone"


def test_a_server_says_that_it_is_there_when_there_is_nothing_new(browser: Browser) -> None:
    with serving(Hub()) as server:
        browser.open(server.url)
        browser.run("window.first = page.heard")
        browser.sees("page.heard > first")


def test_a_page_that_was_closed_and_opened_shows_the_present(browser: Browser) -> None:
    hub = Hub()
    heard = Heard("/node", hub)
    told = Told(line_follower())
    told.to(heard)
    with serving(hub) as server:
        browser.open(server.url)
        browser.sees(is_in("Motor", told.state["components"]["Motor"]))
        before = told.state["components"]["Motor"]
        while told.state["components"]["Motor"] == before:
            told.step()
            heard.event(json.dumps(told.event))
        # Nobody looks at it: it follows nothing, and leaves its stream to other pages.
        browser.run(
            "Object.defineProperty(document, 'hidden', {value: true, configurable: true});"
            "document.dispatchEvent(new Event('visibilitychange'))"
        )
        browser.sees("link.stream === null")
        told.to(heard)
        browser.run("delete document.hidden; document.dispatchEvent(new Event('visibilitychange'))")
        browser.sees(is_in("Motor", told.state["components"]["Motor"]))
        numbers = browser.run("return page.events.map((e) => e.number)")
        assert numbers == sorted(set(numbers))
