"""What a shadow would send stands beside what was really sent."""

from __future__ import annotations

import json
from typing import Any

from view.browser import Browser
from view.watching import Told, line_follower, serving

from robosc.view.hub import Hub
from robosc.view.listening import Heard


def test_what_would_be_sent_stands_beside_what_was(browser: Browser) -> None:
    hub = Hub()
    told, heard = Told(line_follower()), Heard("/shadow", hub)
    told.to(heard)
    number = told.state["number"]

    def say(speed: float, **more: Any) -> None:
        nonlocal number
        number += 1
        event = {"kind": "request", "name": "move", "value": {"linear": {"x": speed}}}
        time = told.state["time"] + number
        document = {"version": 1, "number": number, "time": time, "event": event, "detail": None}
        heard.event(json.dumps({**document, "outcome": "applied", **more}))
        counters = {**told.state["counters"], "withheld": 1}
        state = {**told.state, "number": number, "time": time, "counters": counters}
        heard.state(json.dumps(state))

    row = "document.querySelector('[data-command=\"move.request\"] .sent').textContent"
    at = r" at \d\d:\d\d:\d\d\.\d\d\d"

    def shows(sent: str, would: float) -> None:
        pattern = f"^{sent} · would send {{linear: {{x: {would}}}}}{at}$"
        browser.sees(f"new RegExp({json.dumps(pattern)}).test({row})")

    with serving(hub) as server:
        browser.open(server.url)
        browser.sees("document.querySelectorAll('[data-command]').length > 0")
        say(0.2, outcome="withheld")
        shows("not sent", 0.2)
        say(0.1, seen=True)
        shows(f"sent {{linear: {{x: 0.1}}}}{at}", 0.2)
        say(0.3, seen=True, outcome="forbidden")
        shows(f"sent {{linear: {{x: 0.3}}}}{at}", 0.2)
        say(0.4, outcome="withheld")
        shows(f"sent {{linear: {{x: 0.3}}}}{at}", 0.4)
        browser.sees("document.querySelector('[data-gauge=withheld]').textContent === '1'")
        line = "document.querySelector('[data-command=\"move.request\"] .sent')"
        browser.sees(f"{line}.scrollWidth <= {line}.clientWidth")  # all of it can be read
        browser.picture("view-shadow")
