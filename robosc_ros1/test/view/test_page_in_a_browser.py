"""The page itself, in a headless browser: playing, and a recording."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import pytest
from view.browser import Browser
from view.watching import Told, line_follower, log_of, serving

from robosc.simulate.machines.event_by_event import SingleEvents
from robosc.view.hub import Hub
from robosc.view.listening import Heard
from robosc.view.played import Played
from robosc.view.recorded import Recording

ARROW_LEFT, ARROW_RIGHT = "\ue012", "\ue014"


def state_of(component: str) -> str:
    return f"document.querySelector('[data-component={component}]')?.dataset.state"


def command(name: str) -> str:
    return f"document.querySelector('[data-command=\"{name}\"]').dataset.is"


@pytest.mark.once
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
        browser.look(1280, 900, "dark")
        browser.picture("view-model")


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


@pytest.mark.once
def test_a_recording_is_gone_through_step_by_step(
    browser: Browser, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    free, obstructed = (("distance", "response", value) for value in ("free", "obstructed"))
    steps: list[Any] = [free, 0.3, ("correction", "response", 12.5), 0.4, obstructed, 0.3]
    lines = log_of(line_follower(), *steps)
    monkeypatch.chdir(tmp_path)
    Path("events.jsonl").write_text("\n".join(lines), encoding="utf-8")
    hub = Hub()
    recording = Recording(line_follower(), "events.jsonl", hub)
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
        browser.look(1280, 900)
        browser.picture("view-log")
        browser.run(
            "const slider = document.getElementById('moment'); slider.focus(); slider.value = 3;"
            "slider.dispatchEvent(new Event('input'))"
        )
        browser.sees("recording.at === 3 && page.events.length === 3")
        browser.press("\ue010")  # end
        browser.sees("recording.at === recording.count")
        browser.press(ARROW_LEFT)
        browser.sees("recording.at === arguments[0]", len(lines) - 1)
        browser.run("document.getElementById('play').click()")
        browser.sees("recording.at === recording.count && !recording.playing")


def test_phases_of_services_and_actions(browser: Browser) -> None:
    hub = Hub()
    played = Played(SingleEvents(line_follower()), hub)

    def phase(name: str) -> str:
        items = "[...document.querySelectorAll('#phases li')]"
        return f"{items}.find((e) => e.textContent.startsWith('{name}'))?.dataset.phase"

    with serving(hub, played.answers) as server:
        browser.open(server.url)
        browser.sees(f"{phase('grab')} === 'idle' && {phase('set_light_state')} === 'idle'")
        for kind, word in (("request", "busy"), ("error", "idle"), ("request", "busy")):
            played.do({"event": {"kind": kind, "name": "set_light_state"}})
            browser.sees(f"{phase('set_light_state')} === '{word}'")
        assert browser.run(f"return {phase('grab')}") == "idle"


_DRAWN = """(id) => {
  const {width, height} = document.getElementById(id);
  if (!width || !height) return [];  // it is not laid out yet
  const {data} = document.getElementById(id).getContext("2d").getImageData(0, 0, width, height);
  const found = new Set();
  for (let i = 0; i < data.length; i += 4) if (data[i + 3] === 255)
    found.add("#" + [data[i], data[i + 1], data[i + 2]].map((n) => n.toString(16).padStart(2, "0")).join(""));
  return [...found];
}"""


def test_mismatches_rates_and_faults_are_told_by_the_clock_of_who_looks(browser: Browser) -> None:
    hub = Hub()
    heard = Heard("/node", hub)
    told = Told(line_follower())
    with serving(hub) as server:
        browser.open(server.url)
        told.state["time"] -= 3600.0  # the robot's clock is slow
        told.to(heard)
        browser.sees("page.shown")
        for _ in range(40):
            told.step()
            told.event["time"] -= 3600.0
            told.state["time"] -= 3600.0
            told.to(heard)
        mismatch = {**told.event, "number": told.event["number"] + 1, "outcome": "mismatch"}
        heard.event(json.dumps(mismatch | {"detail": "it is idle"}))
        told.state["counters"]["mismatches"] = 1
        told.state["faults"] = ["the log cannot be written"]
        heard.state(json.dumps(told.state))
        counted = (
            "[...page.times.seconds.values()].reduce((n, s) => n + s.robot + s.own + s.bad, 0)"
        )
        browser.sees(f"{counted} === 41")
        browser.sees("page.times.ticks.every((t) => Math.abs(t.time - Date.now() / 1000) < 300)")
        for chart in ("rates", "lanes"):
            # In the colour of what went wrong, at least the mismatch.
            browser.sees(f"({_DRAWN})('{chart}').includes(colourOf('--halt').trim())")
        gauge = "document.querySelector('[data-gauge=mismatches]')"
        browser.sees(f"{gauge}.textContent === '1' && {gauge}.parentNode.className === 'trouble'")
        browser.sees("document.querySelector('#events .bad').textContent.includes('it is idle')")
        browser.sees(
            "document.getElementById('faults').textContent === 'the log cannot be written'"
        )


def test_a_picture_that_is_held_stays_and_then_catches_up(browser: Browser) -> None:
    hub = Hub()
    played = Played(SingleEvents(line_follower()), hub)
    with serving(hub, played.answers) as server:
        browser.open(server.url)
        browser.sees(f"{state_of('DistanceSensor')} === 'waiting'")
        browser.press(" ")
        browser.sees("document.getElementById('link').textContent === 'held'")
        played.do({"event": {"kind": "response", "name": "distance", "value": "free"}})
        browser.sees("page.number === 1")
        browser.sees("performance.now() - page.listed > 600")
        assert browser.run(f"return {state_of('DistanceSensor')}") == "waiting"
        browser.press(" ")
        browser.sees(f"{state_of('DistanceSensor')} === 'sensing'")
        browser.sees("document.getElementById('events').childElementCount === 1")
