"""What the robot calls on the page: the robot decides that it calls, the controller what it answers."""

from __future__ import annotations

from emit.golden_packages import model_path
from view.browser import Browser
from view.watching import Told, serving

from robosc import pipeline
from robosc.view.hub import Hub
from robosc.view.listening import Heard

EDGES = """return [...document.querySelectorAll("[data-component=Missions] .edge")].map((edge) => [
  edge.classList.contains("controllable"),
  [...edge.querySelectorAll("text")].map((text) => text.textContent).join(" ")]);"""
SORTS = """return ["request", "cancel", "feedback", "response", "error"].map((kind) =>
  sortOf({ event: { kind, name: "mission" }, outcome: "applied" }));"""


def test_who_decides_on_calls(browser: Browser) -> None:
    told = Told(pipeline.supervise(pipeline.load(model_path("missions")).robot))
    heard = Heard("/missions_controller", Hub())
    told.to(heard)
    with serving(heard._hub) as server:
        browser.open(server.url)
        browser.sees("page.shown")
        edges = browser.run(EDGES)
        assert len(edges) == 4
        for controllable, text in edges:
            assert controllable is not any(
                word in text for word in ("mission.request", "mission.cancel")
            ), edges
        assert browser.run(SORTS) == ["robot", "robot", "own", "own", "own"]
