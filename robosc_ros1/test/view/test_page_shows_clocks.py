"""How long ago a watched message came, and how long clocks still run, while time goes on."""

from __future__ import annotations

from view.browser import Browser
from view.watching import Told, line_follower, serving

from robosc.view.hub import Hub
from robosc.view.listening import Heard

CLOCK = "(document.querySelector(`[data-clock='${arguments[0]}']`)?.textContent ?? '')"


def test_ages_and_times_that_are_left(browser: Browser) -> None:
    heard = Heard("/robot", Hub())
    told = Told(line_follower())
    time = told.state["time"]
    told.state["communications"]["distance"] = "fresh"
    told.state["clocks"] = {"distance": 60.0, "Door.opened": 90.0}
    told.event = {
        "version": 1, "number": told.state["number"], "time": time - 5.0,
        "event": {"kind": "response", "name": "distance", "value": "free"},
        "outcome": "applied", "detail": None,
    }  # fmt: skip
    told.to(heard)
    with serving(heard._hub) as server:
        browser.open(server.url)
        of_message = rf"/^distance: heard ([\d.]+) s ago, silent in ([\d.]+) s$/.exec({CLOCK})"
        browser.sees(f"{of_message}?.[1] >= 5 && {of_message}[2] <= 60", "distance")
        of_state = rf"/^Door\.opened: ([\d.]+) s left$/.exec({CLOCK})?.[1]"
        browser.sees(f"{of_state} <= 90", "Door.opened")
        # They go on by themselves.
        first = float(browser.run(f"return {of_state}", "Door.opened"))
        browser.sees(f"{of_state} < arguments[1]", "Door.opened", first)
        browser.picture("view-clocks")
        # Silence stops them, and what was heard is still known.
        told.state |= {"clocks": {}, "number": told.state["number"] + 1}
        told.state["communications"]["distance"] = "silent"
        told.to(heard)
        browser.sees(rf"/^distance: heard [\d.]+ s ago$/.test({CLOCK})", "distance")
        browser.sees("document.querySelectorAll('#clocks li').length === 1")
