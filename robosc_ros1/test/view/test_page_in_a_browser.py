"""The page itself, in a headless browser: playing, a recording, a large robot."""

from __future__ import annotations

import json
import threading
from pathlib import Path
from typing import Any

import pytest
from view.browser import Browser
from view.watching import line_follower, log_of, serving

from robosc.simulate.single import SingleEvents
from robosc.view.hub import Hub
from robosc.view.played import Played
from robosc.view.recorded import Recording

ARROW_LEFT, ARROW_RIGHT = "\ue012", "\ue014"


def state_of(component: str) -> str:
    return f"document.querySelector('[data-component={component}]')?.dataset.state"


def command(name: str) -> str:
    return f"document.querySelector('[data-command=\"{name}\"]').dataset.is"


def test_a_click_on_an_event_of_the_robot_fires_it(browser: Browser) -> None:
    hub = Hub()
    played = Played(SingleEvents(line_follower()), hub)
    with serving(hub, played.answers) as server:
        browser.open(server.url)
        browser.sees(f"{state_of('DistanceSensor')} === 'waiting'")
        browser.run("document.querySelector('[data-choice=\"distance.response(free)\"]').click()")
        browser.sees(f"{state_of('DistanceSensor')} === 'sensing'")
        browser.sees(f"{command('move.request')} === 'enabled'")
        # The label in the diagram does the same, where there is one value to send.
        browser.run("document.activeElement.blur()")
        browser.run(
            "[...document.querySelectorAll('[data-component=Motor] .words')]"
            ".find((w) => w.textContent.startsWith('move.request'))"
            ".dispatchEvent(new MouseEvent('click'))"
        )
        sent = "document.querySelector('[data-command=\"move.request\"] .sent').textContent"
        browser.sees(f"{sent} === 'sent {{linear: {{x: 0.2}}, angular: {{z: 0}}}}'")
        flashed = "document.querySelectorAll('[data-component=Motor] [data-flashed]').length"
        assert browser.run(f"return {flashed}") == 1
        for scheme in ("light", "dark"):
            browser.look(scheme=scheme)
            browser.picture(f"view-model-{scheme}")


def test_all_is_done_by_keyboard(browser: Browser) -> None:
    hub = Hub()
    played = Played(SingleEvents(line_follower()), hub)
    with serving(hub, played.answers) as server:
        browser.open(server.url)
        browser.sees(f"{state_of('DistanceSensor')} === 'waiting'")
        browser.press("2")
        browser.sees("document.getElementById('events').innerText.includes('obstructed')")
        browser.press("3")  # its value is to be typed
        browser.sees("document.activeElement.tagName === 'INPUT'")
        browser.press("12.5\ue007")
        browser.sees(f"{state_of('LineDetector')} === 'line_found'")
        browser.press("\ue00cu")  # escape leaves the field
        browser.sees(f"{state_of('LineDetector')} === 'no_line'")
        browser.press("/distance")
        browser.sees("!document.getElementById('events').innerText.includes('correction')")
        browser.press("\ue00c?")
        browser.sees("document.getElementById('help-box').open")


def test_what_is_refused_is_told(browser: Browser) -> None:
    hub = Hub()
    played = Played(SingleEvents(line_follower()), hub)
    with serving(hub, played.answers) as server:
        browser.open(server.url)
        browser.sees("page.choices.length")
        browser.press("3")
        browser.press("far\ue007")
        browser.sees("document.getElementById('refused').textContent.includes('far')")
        # The browser's console tells of the refusal, as of every answer that is no success.
        (told,) = browser.complaints()
        assert "409" in told


def test_a_recording_is_gone_through_step_by_step(browser: Browser, tmp_path: Path) -> None:
    steps: list[Any] = [
        ("distance", "response", "free"),
        0.3,
        ("distance", "response", "obstructed"),
        0.2,
    ]
    lines = log_of(line_follower(), *steps)
    path = tmp_path / "events.jsonl"
    path.write_text("\n".join(lines), encoding="utf-8")
    hub = Hub()
    recording = Recording(line_follower(), str(path), hub)
    with serving(hub, recording.answers) as server:
        browser.open(server.url)
        browser.sees("recording.at === 1")
        for at in range(2, len(lines) + 1):
            browser.press(ARROW_RIGHT)
            browser.sees("recording.at === arguments[0]", at)
            expected = recording.moment({"at": at})["state"]
            for component, state in expected["components"].items():
                browser.sees(f"{state_of(component)} === '{state}'")
            for told in expected["commands"]:
                name = f"{told['event']['name']}.{told['event']['kind']}"
                browser.sees(f"({command(name)} === 'enabled') === arguments[0]", told["enabled"])
        browser.look()
        browser.picture("view-log")
        browser.press(ARROW_LEFT)
        browser.sees("recording.at === arguments[0]", len(lines) - 1)
        browser.run("document.getElementById('play').click()")
        browser.sees("recording.at === recording.count && !recording.playing")


COPIES = 6
RATE = 100
SECONDS = 4


def large_robot() -> tuple[dict[str, Any], dict[str, Any]]:
    """Model and state of six line followers in one: 30 components."""
    hub = Hub()
    Played(SingleEvents(line_follower()), hub)
    news = json.loads(hub.follow().take(1) or "")
    model, state = news["model"], news["state"]
    state.pop("choices")

    components = [c["name"] for c in model["components"]]
    communications = {c["name"] for c in model["communications"]}

    def renamed(value: Any, n: int) -> Any:
        if isinstance(value, dict):
            found = {renamed(k, n): renamed(v, n) for k, v in value.items()}
            if "kind" in found and found.get("name") in communications:
                found["name"] += str(n)
            return found
        if isinstance(value, list):
            return [renamed(part, n) for part in value]
        for component in components if isinstance(value, str) else ():
            value = value.replace(component, f"{component}{n}")
        return value

    for name in ("components", "communications", "commands"):
        model[name] = [renamed(part, n) for n in range(COPIES) for part in model[name]]
    state["commands"] = [renamed(part, n) for n in range(COPIES) for part in state["commands"]]
    for name in ("components", "variables"):
        state[name] = {k: v for n in range(COPIES) for k, v in renamed(state[name], n).items()}
    return model, state


@pytest.mark.parametrize(("width", "scheme"), [(1400, "light"), (390, "dark")])
def test_thirty_components_at_a_hundred_events_per_second(
    browser: Browser, width: int, scheme: str
) -> None:
    model, state = large_robot()
    hub = Hub()
    hub.put("hello", '{"source":"ros","title":"/large"}')
    hub.put("status", '{"good":true,"text":"live"}')
    hub.put("model", json.dumps(model))
    hub.put("state", json.dumps(state))
    browser.look(width, 1000, scheme)
    with serving(hub) as server:
        browser.open(server.url)
        browser.sees(f"page.cards.size === {5 * COPIES}")
        browser.run(
            "window.frames_ = []; let before = performance.now();"
            "const step = (now) => { frames_.push(now - before); before = now; requestAnimationFrame(step); };"
            "requestAnimationFrame(step);"
        )
        pace = threading.Event()
        for number in range(1, RATE * SECONDS + 1):
            n = number % COPIES
            where = "sensing" if number % 2 else "waiting"
            state["components"][f"DistanceSensor{n}"] = where
            state["number"] = number
            state["time"] = number / RATE
            event = {"kind": "response", "name": f"distance{n}", "value": "free"}
            hub.put("state", json.dumps(state))
            hub.add([json.dumps({"version": 1, "number": number, "time": number / RATE,
                                 "event": event, "outcome": "applied", "detail": None})])  # fmt: skip
            pace.wait(1 / RATE)
        browser.sees("page.number === arguments[0] && page.events.length === arguments[0]", number)
        browser.sees(f"{state_of(f'DistanceSensor{n}')} === '{where}'")
        assert browser.run("return document.getElementById('events').childElementCount") == 120
        frames = sorted(browser.run("return frames_"))
        print(
            f"{len(frames)} frames, median {frames[len(frames) // 2]:.0f} ms, longest {frames[-1]:.0f} ms"
        )
        assert browser.run("return document.documentElement.scrollWidth <= innerWidth")
        browser.picture(f"view-large-{scheme}")
