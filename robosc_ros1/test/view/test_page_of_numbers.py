"""Numbers over time beside the states, what they are compared with, and looking closer."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import pytest
from runtime.schemas import validate
from view.browser import Browser
from view.watching import Told, is_in, log_of, serving

from robosc import pipeline
from robosc.simulate.machines.event_by_event import SingleEvents
from robosc.supervisor import Supervisor
from robosc.view.hub import Hub
from robosc.view.listening import Heard
from robosc.view.played import Played
from robosc.view.recorded import Recording

MODEL = """
robot Cart {
    component Gauge {
        outgoing message distance with type: double
        behaviour {
            variable near: double = 0.0
            on response from distance do near := value
            initial marked state waiting { on response from distance goto sensing }
            marked state sensing {}
        }
    }
    component Drive {
        incoming message go with type: none
        behaviour { initial marked state there { on request to go } }
    }
    requirement go needs Gauge.near > 0.35 and Gauge.sensing
}
"""
COLOURS = """(canvas) => {
  const {width, height} = canvas;
  if (!width || !height) return new Set();  // it is not laid out yet
  const {data} = canvas.getContext("2d").getImageData(0, 0, width, height);
  const found = new Set();
  for (let i = 0; i < data.length; i += 4) if (data[i + 3] === 255)
    found.add("#" + [data[i], data[i + 1], data[i + 2]].map((n) => n.toString(16).padStart(2, "0")).join(""));
  return found;
}"""


@pytest.fixture(scope="module")
def supervisor(tmp_path_factory: pytest.TempPathFactory) -> Supervisor:
    path = tmp_path_factory.mktemp("cart") / "cart.rscd"
    path.write_text(MODEL, encoding="utf-8")
    return pipeline.supervise(pipeline.load(path).robot)


def drawn(plot: str, colour: str) -> str:
    """A plot has something in a colour of the page."""
    canvas = f"document.querySelector('[data-plot=\"{plot}\"]')"
    return f"({COLOURS})({canvas}).has(colourOf('{colour}').trim())"


def measure(value: float) -> Any:
    return "distance", "response", value


def test_a_recording_tells_how_all_went(supervisor: Supervisor, tmp_path: Path) -> None:
    path = tmp_path / "events.jsonl"
    steps = [step for i in range(40) for step in (measure(i % 7 / 10), 0.2)]
    path.write_text("\n".join(log_of(supervisor, *steps)), encoding="utf-8")
    recording = Recording(supervisor, str(path), Hub())
    validate(recording.model, "model")
    (near,) = recording.model["components"][0]["variables"]
    assert near["comparisons"] == [[">", 0.35]]
    assert near["classes"] == {"0": "!(Gauge.near > 0.35)", "1": "Gauge.near > 0.35"}
    series = {s["name"]: s for s in recording.overview({})["series"]}
    assert set(series) == {"Gauge", "Gauge.near", "Drive", "distance.response"}

    def at(name: str, place: int) -> Any:
        known = zip(series[name]["places"], series[name]["values"], strict=True)
        return [value for begin, value in known if begin <= place][-1]

    for place in range(1, recording.hello["count"] + 1):
        state = recording.moment({"at": place})["state"]
        assert at("Gauge.near", place) == state["variables"]["Gauge.near"]
        assert {name: at(name, place) for name in ("Gauge", "Drive")} == state["components"]
    assert series["distance.response"]["component"] == "Gauge"
    assert series["distance.response"]["values"] == [i % 7 / 10 for i in range(40)]


def test_a_number_stands_with_its_class_its_past_and_its_thresholds(
    supervisor: Supervisor, browser: Browser
) -> None:
    hub = Hub()
    played = Played(SingleEvents(supervisor), hub)
    with serving(hub, played.answers) as server:
        browser.open(server.url)
        browser.sees("page.shown")
        cell = "[...document.querySelector('[data-component=Gauge] .variables td + td').children]"
        for value, text in (
            (0.123456789, "<= 0.35 0.123457"),
            (0.35, "<= 0.35 0.35"),
            (0.3500000001, "> 0.35 0.35"),
        ):
            event = {"kind": "response", "name": "distance", "value": value}
            played.do({"event": event})
            browser.sees(f"{cell}.map((e) => e.innerText).join(' ') === arguments[0]", text)
            exact = "document.querySelector('[data-component=Gauge] .variables span').title"
            assert browser.run(f"return {exact}") == str(value)
        for plot in ("Gauge.near", "distance.response"):
            browser.sees(drawn(plot, "--accent"))
        browser.sees(drawn("Gauge.near", "--wait"))
        for width in (1280, 360, 1920, 700):
            browser.look(width, 900)
            browser.sees(
                "[...document.querySelectorAll('.plot')].every((plot) => !plotOf.get(plot).visible"
                " || Math.abs(plot.firstElementChild.offsetWidth - plot.clientWidth) < 2)"
            )
            cards = "[...document.querySelectorAll('.card')]"
            assert browser.run(f"return {cards}.every((c) => c.scrollWidth <= c.clientWidth)")
            assert browser.run("return document.documentElement.scrollWidth <= innerWidth")
        assert not browser.run(f"return {drawn('distance.response', '--wait')}")


def test_one_goes_back_while_the_picture_is_held(supervisor: Supervisor, browser: Browser) -> None:
    told = Told(supervisor)
    heard = Heard("/cart", Hub())
    with serving(heard._hub) as server:
        browser.open(server.url)
        for number in range(1, 7):
            told.state |= {"number": number, "time": told.state["time"] + 1.0}
            told.state["components"]["Gauge"] = "waiting" if number % 2 else "sensing"
            told.to(heard)
            browser.sees("page.shown?.number === arguments[0]", number)
        browser.press(" ")
        browser.sees("page.held && !document.getElementById('scrub').hidden")
        for number in (5, 4, 3):
            browser.press("\ue012")  # left
            browser.sees("page.shown.number === arguments[0]", number)
            browser.sees(is_in("Gauge", "waiting" if number % 2 else "sensing"))
        told.state |= {"number": 7}
        told.to(heard)
        browser.sees("page.state.number === 7")
        assert browser.run("return page.shown.number") == 3
        slider = "document.getElementById('moment')"
        browser.run(f"{slider}.value = 1; {slider}.dispatchEvent(new Event('input'))")
        browser.sees("page.shown.number === 2")
        browser.press(" ")
        browser.sees("page.shown.number === 7 && document.getElementById('scrub').hidden")


def test_diagrams_are_zoomed_and_panels_resized(supervisor: Supervisor, browser: Browser) -> None:
    hub = Hub()
    played = Played(SingleEvents(supervisor), hub)
    with serving(hub, played.answers) as server:
        browser.open(server.url)
        browser.sees("page.shown")
        pane = "[data-component=Gauge] .drawing"
        box = f"document.querySelector('{pane} svg').getAttribute('viewBox')"
        whole = browser.run(f"return {box}")
        zoom = "document.querySelectorAll('[data-component=Gauge] .zoom button')"
        browser.run(f"{zoom}[1].click()")
        x, y, width, _ = map(float, browser.run(f"return {box}").split())
        assert width == pytest.approx(float(whole.split()[2]) / 1.5, abs=0.1)
        start = browser.middle(pane)
        down, up = ({"type": kind, "button": 0} for kind in ("pointerDown", "pointerUp"))
        drag = [{"type": "pointerMove", "x": start["x"] - d, "y": start["y"] - d} for d in (9, 20)]
        browser.mouse(start, down, *drag, up)
        moved = [float(n) for n in browser.run(f"return {box}").split()[:2]]
        assert moved[0] > x
        assert moved[1] > y
        browser.run(f"{zoom}[0].click()")
        assert browser.run(f"return {box}") == whole

        side = "document.querySelector('.side').offsetWidth"
        before = browser.run(f"return {side}")
        start = browser.middle("#split-side")
        browser.mouse(start, down, {**start, "x": start["x"] - 50}, up)
        assert browser.run(f"return {side}") == before + 50
        browser.press("\ue014")  # right, on the bar that has the focus
        assert browser.run(f"return {side}") == before + 26
        browser.run(f"{zoom}[1].click(); {zoom}[1].click()")
        closer = browser.run(f"return {box}")
        browser.sees(
            f"location.hash.includes('side={before + 26}') && location.hash.includes('zoom')"
        )
        link = browser.run("return location.href")
        browser.open("about:blank")
        browser.open(link)
        browser.sees(f"{side} === {before + 26}")
        browser.sees(f"{box} === arguments[0]", closer)
