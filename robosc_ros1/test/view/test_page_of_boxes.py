"""States in states on the page: nested boxes, entered and left together with the picture."""

from __future__ import annotations

import random
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest
from nested_models import PARTS, nested_text, random_behaviour
from view.browser import Browser
from view.watching import Told, serving

from robosc import pipeline
from robosc.view.hub import Hub
from robosc.view.listening import Heard

PATROL = Path(__file__).parents[3] / "examples" / "patrol" / "patrol.rscd"
WIDTHS = (1400, 420)
BOXES = """return [...document.querySelectorAll("#components svg")].map((svg) => {
  const whole = (e) => { const r = e.getBBox(); return [r.x, r.y, r.x + r.width, r.y + r.height]; };
  return {
    boxes: [...svg.querySelectorAll(".box")].map((b) => [b.textContent, ...whole(b.querySelector("rect"))]),
    states: [...svg.querySelectorAll(".state")].map((s) => [
      s.querySelector("title")?.textContent ?? s.querySelector("text").textContent, ...whole(s.querySelector("rect"))]),
    paths: [...svg.querySelectorAll(".edge path")].map((p) => p.getAttribute("d")),
    size: [0, 0, svg.viewBox.baseVal.width, svg.viewBox.baseVal.height],
  };
});"""


def contains(outer: list[Any], inner: list[Any]) -> bool:
    return bool(
        outer[0] <= inner[0]
        and outer[1] <= inner[1]
        and outer[2] >= inner[2]
        and outer[3] >= inner[3]
    )


def apart(one: list[Any], other: list[Any]) -> bool:
    return bool(
        one[2] <= other[0] or other[2] <= one[0] or one[3] <= other[1] or other[3] <= one[1]
    )


def check(drawing: dict[str, Any]) -> None:
    """Each box holds the states in it and no others; no two states touch."""
    assert not [path for path in drawing["paths"] if "NaN" in path or "und" in path]
    paths = [name for name, *_ in drawing["states"]]
    heads = {path.rpartition(".")[0] for path in paths} - {""}
    assert {name for name, *_ in drawing["boxes"]} >= {head.rpartition(".")[2] for head in heads}
    for name, *place in (*drawing["states"], *drawing["boxes"]):
        assert contains(drawing["size"], place), name
    for number, (name, *place) in enumerate(drawing["states"]):
        for other, *there in drawing["states"][:number]:
            assert apart(place, there), (name, other)
        around = [box for box, *there in drawing["boxes"] if contains(there, place)]
        assert sorted(around) == sorted(name.split(".")[:-1]), name
        for box, *there in drawing["boxes"]:
            assert contains(there, place) or apart(there, place), (name, box)


@pytest.fixture
def told(browser: Browser) -> Iterator[Told]:
    told = Told(pipeline.supervise(pipeline.load(PATROL).robot))
    heard = Heard("/patrol_controller", Hub())
    told.to(heard)
    with serving(heard._hub) as server:
        browser.open(server.url)
        browser.sees("page.shown")
        yield told


def test_a_mission_is_drawn_as_it_is_written(told: Told, browser: Browser) -> None:
    for width in WIDTHS:
        browser.look(width, 1100)
        drawings = browser.run(BOXES)
        (mission,) = (d for d in drawings if d["boxes"])
        check(mission)
        assert {name for name, *_ in mission["states"]} == {
            "charging", "leaving", "patrol.to_gate", "patrol.at_gate", "patrol.to_store",
            "returning", "docking", "stranded", "waiting",
        }  # fmt: skip
        browser.picture(f"boxes-{width}")
        assert browser.run("return document.documentElement.scrollWidth <= innerWidth")
    assert "performs drive" in browser.run(
        "return document.querySelector('#components').textContent"
    )


@pytest.mark.parametrize("seed", range(6))
def test_random_ones(browser: Browser, tmp_path: Path, seed: int) -> None:

    number = seed * 10
    robot = None
    while robot is None:  # from some state no marked one can be reached
        path = tmp_path / "model.rscd"
        text = nested_text(random_behaviour(random.Random(number)), ())
        path.write_text(f"robot Test {{ {PARTS % text} }}", encoding="utf-8")
        checked = pipeline.check(path)
        number += 1
        robot = pipeline.load(path).robot if not checked.exit_code else None
    told = Told(pipeline.supervise(robot))
    heard = Heard("/test_controller", Hub())
    told.to(heard)
    with serving(heard._hub) as server:
        browser.open(server.url)
        browser.sees("page.shown")
        for drawing in browser.run(BOXES):
            check(drawing)
        browser.picture(f"boxes-random-{seed}")
