"""The page by keyboard and for those who do not see it, or see little of it."""

from __future__ import annotations

import shutil
import subprocess
import tarfile
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import pytest
from ros_support import REPOSITORY
from view.browser import Browser
from view.watching import is_in, line_follower, log_of, serving

from robosc.simulate.machines.event_by_event import SingleEvents
from robosc.view.hub import Hub
from robosc.view.played import Played
from robosc.view.recorded import Recording

AXE = "4.14.1"
TAB, ENTER = "\ue004", "\ue007"
SOURCES = ("model", "log")


@pytest.fixture(scope="session")
def axe() -> str:
    """The rules of axe-core (W3C's WCAG, as far as a program can judge them)."""
    folder = REPOSITORY / ".cache" / "axe"
    archive = folder / f"axe-core-{AXE}.tgz"
    if not archive.is_file():
        if shutil.which("npm") is None:
            pytest.skip("there is no npm, which fetches axe-core")
        folder.mkdir(parents=True, exist_ok=True)
        done = subprocess.run(
            ["npm", "pack", "--silent", f"axe-core@{AXE}"],
            cwd=folder, capture_output=True, text=True, timeout=600,
        )  # fmt: skip
        if done.returncode:
            pytest.skip(f"axe-core cannot be had: {done.stderr.strip()[-200:]}")
    with tarfile.open(archive) as packed:
        program = packed.extractfile("package/axe.min.js")
        assert program is not None
        return program.read().decode()


@contextmanager
def page(source: str, browser: Browser, folder: Path) -> Iterator[None]:
    """A line follower to play with, or a recording of one."""
    hub = Hub()
    if source == "model":
        played = Played(SingleEvents(line_follower()), hub)
        played.do({"random": 20})
        answers = played.answers
    else:
        log = folder / "events.jsonl"
        steps: list[Any] = [
            ("distance", "response", "free"),
            0.3,
            ("distance", "response", "obstructed"),
        ]
        log.write_text("\n".join(log_of(line_follower(), *steps)), encoding="utf-8")
        answers = Recording(line_follower(), str(log), hub).answers
    with serving(hub, answers) as server:
        browser.open(server.url)
        browser.sees("page.state && page.cards.size && page.listed")
        yield


@pytest.mark.parametrize("source", SOURCES)
def test_no_rule_of_accessibility_is_broken(
    source: str, browser: Browser, axe: str, tmp_path: Path
) -> None:
    with page(source, browser, tmp_path):
        browser.run(f"{axe}; window.axe = axe")
        for scheme in ("light", "dark"):
            for width in (1280, 320):
                browser.look(width, 900, scheme)
                assert broken_rules(browser) == [], (scheme, width)
        browser.press("?")
        browser.sees("document.getElementById('help-box').open")
        assert broken_rules(browser) == []


def broken_rules(browser: Browser) -> Any:
    # What flashes just now has other colours for a moment.
    browser.sees("document.getAnimations().length === 0")
    browser.run(
        "window.found = null; axe.run(document).then((result) => { window.found = result.violations"
        ".map((v) => [v.id, v.help, ...v.nodes.map((n) => n.html)]) })"
    )
    browser.sees("found !== null")
    return browser.run("return found")


_CONTROLS = """
return [...document.querySelectorAll("button, a[href], input, select, [tabindex='0']")]
  .filter((e) => !e.disabled && e.checkVisibility()).map(nameOf)
"""
_WATCH_FOCUS = """
window.nameOf = (e) => (e.id || e.getAttribute("href") || e.ariaLabel || e.textContent) + " " + e.tagName;
window.reached = [];
addEventListener("focusin", ({target}) => {
  const style = getComputedStyle(target);
  reached.push([nameOf(target), style.outlineStyle !== "none" && parseFloat(style.outlineWidth) >= 2]);
});
"""


@pytest.mark.parametrize("width", [1280, 320])
@pytest.mark.parametrize("source", SOURCES)
def test_every_control_is_reached_by_the_tab_key_and_shows_that_it_is(
    source: str, width: int, browser: Browser, tmp_path: Path
) -> None:
    browser.look(width, 900)
    with page(source, browser, tmp_path):
        browser.run(_WATCH_FOCUS)
        controls = set(browser.run(_CONTROLS))
        assert len(controls) > 8
        browser.press(TAB * (len(controls) + 12))
        reached = browser.run("return reached")
        assert controls <= {name for name, _ in reached}
        assert [name for name, visible in reached if not visible] == []


def test_what_stands_at_a_transition_is_a_button_while_it_can_happen(
    browser: Browser, tmp_path: Path
) -> None:
    hub = Hub()
    played = Played(SingleEvents(line_follower()), hub)
    words = "[...document.querySelectorAll('[data-component=LineDetector] .words')]"
    line = f"{words}.find((w) => w.textContent.startsWith('no_line.response'))"
    played.do({"event": {"kind": "response", "name": "correction", "value": 1.5}})
    with serving(hub, played.answers) as server:
        browser.open(server.url)
        browser.sees(is_in("LineDetector", "line_found"))
        browser.sees(f"{line}.getAttribute('role') === 'button'")
        browser.run(f"{line}.focus()")
        browser.press(ENTER)
        browser.sees(is_in("LineDetector", "no_line"))


def test_a_wish_for_less_motion_is_kept(browser: Browser) -> None:
    hub = Hub()
    played = Played(SingleEvents(line_follower()), hub)
    features = [{"name": "prefers-reduced-motion", "value": "reduce"}]
    browser._command("Emulation.setEmulatedMedia", {"features": features})
    with serving(hub, played.answers) as server:
        browser.open(server.url)
        browser.sees("page.choices.length")
        played.do({"event": {"kind": "response", "name": "distance", "value": "free"}})
        browser.sees("document.querySelector('[data-component=DistanceSensor] [data-flashed]')")
        assert browser.run(
            "return document.getAnimations().every((a) => a.effect.getTiming().easing.startsWith('steps'))"
        )
