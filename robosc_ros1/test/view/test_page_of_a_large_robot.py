"""A robot of thirty components that does a hundred things per second, on a screen and on a phone."""

from __future__ import annotations

import json
import threading
import time

import pytest
from large_model import large_model
from view.browser import Browser
from view.watching import Told, is_in, serving

from robosc import pipeline
from robosc.view.hub import Hub
from robosc.view.listening import Heard

COMPONENTS = 30
RATE = 100
SECONDS = 4

_WATCH_FRAMES = """
window.watched = {frames: [], long: []};
let before = performance.now();
const step = (now) => { watched.frames.push(now - before); before = now; requestAnimationFrame(step); };
requestAnimationFrame(step);
new PerformanceObserver((list) => watched.long.push(...list.getEntries().map((e) => e.duration)))
  .observe({type: "longtask"});
"""


@pytest.fixture(scope="module")
def steps(tmp_path_factory: pytest.TempPathFactory) -> tuple[Told, list[tuple[str, str]]]:
    """What a node of that robot told in the end, and each event before with the state after it.

    Beforehand, as this process would not have the time while the page is watched.
    """
    pytest.importorskip("oxidd", reason="the symbolic engine needs the Python package oxidd")
    path = tmp_path_factory.mktemp("large") / "plant.rscd"
    path.write_text(large_model(COMPONENTS), encoding="utf-8")
    told = Told(pipeline.supervise(pipeline.load(str(path)).robot))
    recorded = []
    for _ in range(RATE * SECONDS):
        told.step()
        recorded.append((json.dumps(told.event), json.dumps(told.state)))
    return told, recorded


@pytest.mark.parametrize(
    ("width", "scheme", "picture"),
    [(1280, "light", "view-large"), (360, "dark", "view-large-phone")],
)
def test_thirty_components_at_a_hundred_events_per_second(
    browser: Browser,
    steps: tuple[Told, list[tuple[str, str]]],
    width: int,
    scheme: str,
    picture: str,
) -> None:
    told, recorded = steps
    hub = Hub()
    heard = Heard("/plant_controller", hub)
    heard.model(json.dumps(told.model))
    browser.look(width, 800, scheme)
    with serving(hub) as server:
        browser.open(server.url)
        browser.sees(
            f"page.cards.size === {sum(bool(c['states']) for c in told.model['components'])}"
        )
        browser.run(_WATCH_FRAMES)
        pace = threading.Event()
        begin = time.monotonic()
        for number, (event, state) in enumerate(recorded):
            pace.wait(max(0.0, begin + number / RATE - time.monotonic()))
            heard.event(event)
            heard.state(state)
        last = told.event["number"]
        browser.sees("page.number === arguments[0]", last)
        numbers = browser.run("return page.events.map((e) => e.number)")
        assert numbers == list(range(numbers[0], last + 1))
        for component, where in told.state["components"].items():
            browser.sees(is_in(component, where))
        told_at_a_glance = "[...document.querySelectorAll('#overview b')].map((b) => b.textContent)"
        moving = [c["name"] for c in told.model["components"] if len(c["states"]) > 1]
        at_a_glance = browser.run(f"return {told_at_a_glance}")
        assert sorted(at_a_glance) == sorted(told.state["components"][name] for name in moving)
        browser.sees("document.getElementById('events').childElementCount === 120")
        report(width, browser.run("return watched"))
        assert browser.run("return document.documentElement.scrollWidth <= innerWidth")
        if picture == "view-large":
            browser.look(1920, 1080)
        browser.picture(picture)


def report(width: int, watched: dict[str, list[float]]) -> None:
    frames = sorted(watched["frames"])
    at = [frames[int(len(frames) * part)] for part in (0.5, 0.95, 0.99)]
    print(
        f"{width} px wide: {len(frames)} frames, median {at[0]:.0f} ms, 95 % {at[1]:.0f} ms,"
        f" 99 % {at[2]:.0f} ms, longest {frames[-1]:.0f} ms;"
        f" long tasks {[round(t) for t in watched['long']]} ms"
    )
