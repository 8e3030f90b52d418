"""Sixty stations on one screen: one drawing, a row of states, and one row of lamps."""

from __future__ import annotations

import json
from collections.abc import Iterator
from pathlib import Path

import pytest
from view.browser import Browser
from view.test_page_for_everyone import axe, broken_rules
from view.watching import Told, is_in, serving

from robosc import pipeline
from robosc.supervisor import Supervisor
from robosc.view.hub import Hub
from robosc.view.listening import Heard

__all__ = ["axe"]

COUNT = 60
MODEL = f"""
robot Agv {{
    component Vehicle {{
        outgoing message arrived with type: none
        incoming message leave with type: none
        behaviour {{
            initial marked state under_way {{ on response from arrived goto there }}
            state there {{ on request to leave goto under_way }}
        }}
    }}
    component Station[1..{COUNT}] {{
        outgoing message call with identifier: "/call_{{index}}", type: none
        incoming message serve with identifier: "/serve_{{index}}", type: none
        behaviour {{
            variable calls: integer(0..9) = 0
            initial marked state idle {{ on response from call do calls := 1 goto waiting }}
            state waiting {{ on request to serve goto idle }}
        }}
    }}
    for i in 1..{COUNT} {{
        requirement Station[i].serve needs Vehicle.there
    }}
}}
"""


@pytest.fixture(scope="module")
def supervisor(tmp_path_factory: pytest.TempPathFactory) -> Supervisor:
    pytest.importorskip("oxidd", reason="the symbolic engine needs the Python package oxidd")
    path = tmp_path_factory.mktemp("copies") / "agv.rscd"
    path.write_text(MODEL, encoding="utf-8")
    return pipeline.supervise(pipeline.load(Path(path)).robot)


@pytest.fixture
def told(supervisor: Supervisor, browser: Browser) -> Iterator[Told]:
    """The page of a controller that has done a hundred things."""
    told = Told(supervisor)
    heard = Heard("/agv_controller", Hub())
    told.to(heard)
    with serving(heard._hub) as server:
        browser.open(server.url)
        browser.sees("page.shown")
        for _ in range(100):
            told.step()
            told.to(heard)
        browser.sees("page.shown.number === 100")
        yield told


def station_states(told: Told) -> list[str]:
    return [told.state["components"][f"Station[{n}]"] for n in range(1, COUNT + 1)]


def test_all_copies_are_seen_at_once(told: Told, browser: Browser) -> None:
    chips = "[...document.querySelectorAll('.copies button')]"
    states = station_states(told)
    assert {"idle", "waiting"} == set(states)
    shown = browser.run(f"return {chips}.map((e) => e.innerText.replace(/\\s+/g, ' '))")
    assert shown == [f"{n} {state}" for n, state in enumerate(states, 1)]
    counts = browser.run(
        "return [...document.querySelectorAll('.folded .state text')].map((e) => e.textContent)"
    )
    assert counts == [f"{state} · {states.count(state)}" for state in ("idle", "waiting")]
    enabled = {
        f"{c['event']['name']}.request": c["enabled"]
        for c in told.state["commands"]
        if c["event"]["name"] != "leave"
    }
    lamps = "[...document.querySelectorAll('.lamps button')]"
    lit = browser.run(f"return {lamps}.map((e) => [e.dataset.command, e.dataset.is === 'enabled'])")
    assert dict(lit) == enabled
    out_of_sight = (
        "filter((e) => { const r = e.getBoundingClientRect();"
        " return r.top < 0 || document.elementFromPoint(r.x + r.width / 2, r.y + r.height / 2)"
        "?.closest('button') !== e })"
    )
    for parts in (chips, lamps):
        assert browser.run(f"return {parts}.length") == COUNT
        assert browser.run(f"return {parts}.{out_of_sight}.length") == 0
    browser.picture("view-copies")
    browser.look(320, 800)
    assert browser.run("return document.documentElement.scrollWidth <= innerWidth")


def test_a_copy_is_unfolded_by_a_click_and_by_a_link(told: Told, browser: Browser) -> None:
    name = f"Station[{station_states(told).index('waiting') + 1}]"
    chip = f"document.querySelector('.copies [title=\"{name}\"]')"
    card = is_in(name, "waiting")
    browser.run(f"{chip}.click()")
    browser.sees(card)
    calls = "document.querySelector('.opened .variables td + td').textContent"
    assert browser.run(f"return {calls}") == "1"
    browser.sees("location.hash.startsWith('#open=Station')")
    link = browser.run("return location.href")
    browser.run(f"{chip}.click()")
    browser.sees("document.querySelectorAll('.opened .card').length === 0")
    browser.open("about:blank")
    browser.open(link)
    browser.sees(card)


def test_reasons_are_those_of_the_copy_that_is_chosen(told: Told, browser: Browser) -> None:
    last = f"Station[{COUNT}]"
    browser.run(f"document.querySelector('[data-command=\"{last}.serve.request\"]').click()")
    browser.sees(f"document.querySelector('.chosen').textContent === 'i = {COUNT}'")
    (reasons,) = (
        c["blocked_by"] for c in told.state["commands"] if c["event"]["name"] == f"{last}.serve"
    )
    shown = "[...document.querySelectorAll('[data-command=\"Station[i].serve.request\"] .why')]"
    texts = json.dumps("\n".join(reason["text"] for reason in reasons))
    browser.sees(f"{shown}.map((e) => e.lastChild.textContent).join('\\n') === {texts}")


def test_no_rule_of_accessibility_is_broken_by_copies(
    told: Told, browser: Browser, axe: str
) -> None:
    browser.run("document.querySelector('.copies button').click()")
    browser.run(f"{axe}; window.axe = axe")
    for scheme in ("light", "dark"):
        browser.look(1280, 900, scheme)
        assert broken_rules(browser) == []
