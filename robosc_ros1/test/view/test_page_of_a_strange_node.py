"""Whatever comes over ROS: the page shows it, or says that it cannot, and goes on."""

from __future__ import annotations

import json
from collections.abc import Iterator
from typing import Any

import pytest
from view.browser import Browser
from view.watching import Told, is_in, line_follower, serving

from robosc.view.hub import Hub
from robosc.view.listening import Heard

EVIL = "<img src=x onerror=\"document.title='evil'\"><script>document.title='evil'</script>"
LONG = "Wörld_机器人_" * 60
NAMES = [EVIL, "constructor", "__proto__", LONG, "\"'`${page};}</style>", "‮drawkcab", ""]


@pytest.fixture
def heard() -> Heard:
    return Heard("/strange", Hub())


@pytest.fixture
def told(heard: Heard, browser: Browser) -> Iterator[Told]:
    """A line follower whose page is open."""
    told = Told(line_follower())
    told.to(heard)
    with serving(heard._hub) as server:
        browser.open(server.url)
        browser.sees("page.state && page.cards.size")
        yield told


def renamed(value: Any, names: dict[str, str]) -> Any:
    """A document with other words for some."""
    if isinstance(value, dict):
        return {renamed(k, names): renamed(v, names) for k, v in value.items()}
    if isinstance(value, list):
        return [renamed(part, names) for part in value]
    if isinstance(value, str):
        head, dot, tail = value.partition(".")
        return names.get(head, head) + dot + names.get(tail, tail)
    return value


@pytest.mark.parametrize("name", NAMES, ids=ascii)
def test_names_are_text(name: str, told: Told, heard: Heard, browser: Browser) -> None:
    words = ("DistanceSensor", "waiting", "sensing", "current", "distance", "move", "LineFollower")
    names = {word: f"{name}{i}" if i else name for i, word in enumerate(words)}
    told.model, told.state = renamed(told.model, names), renamed(told.state, names)
    told.model["components"][0]["transitions"][0]["assignments"] = [EVIL]
    for command in told.state["commands"]:
        command["blocked_by"] = [{"kind": "requirement", "text": EVIL + name, "place": EVIL}]
    told.state["stopped"] = EVIL
    told.event = {
        "version": 1, "number": told.state["number"] + 1, "time": told.state["time"],
        "event": {"kind": "response", "name": names["distance"], "value": {name: [EVIL, name]}},
        "outcome": "mismatch", "detail": EVIL,
    }  # fmt: skip
    told.to(heard)
    robot = names["LineFollower"]
    browser.sees("document.getElementById('robot').textContent === arguments[0]", robot)
    shown = "page.cards.get(arguments[0])?.element.dataset.state === arguments[1]"
    browser.sees(shown, names["DistanceSensor"], names["waiting"])
    browser.sees("document.getElementById('events').textContent.includes(arguments[0])", EVIL)
    browser.sees("document.querySelector('.why').textContent.startsWith(arguments[0])", EVIL)
    browser.sees("document.getElementById('alert').textContent.includes(arguments[0])", EVIL)
    assert browser.run("return document.title") == f"{robot} · robosc".strip()
    assert browser.run("return document.querySelectorAll('main img, main script').length") == 0
    for width in (320, 1280):
        browser.look(width)
        browser.sees("document.documentElement.scrollWidth <= innerWidth")


@pytest.mark.parametrize(
    ("value", "text"),
    [
        ("9007199254740993", "9007199254740993"),
        ("-18446744073709551615", "-18446744073709551615"),
        ("1e300", "1e+300"),
        ("NaN", "NaN"),
        ("-Infinity", "-Infinity"),
        ("0.1", "0.1"),
        ("1234567.5", "1234567.5"),
        ("-0.0000123456789", "-0.0000123457"),
        ('""', ""),
        ('"' + "x" * 10_000 + '"', "x" * 299 + "…"),
        ("null", ""),
    ],
    ids=lambda text: text[:20],
)
def test_values_are_shown_as_they_are(
    value: str, text: str, told: Told, heard: Heard, browser: Browser
) -> None:
    told.state["variables"]["LineDetector.current_correction"] = "@"
    heard.state(json.dumps(told.state).replace('"@"', value))
    cell = "document.querySelector('[data-component=LineDetector] .variables td + td').textContent"
    browser.sees(f"{cell} === arguments[0]", text)


BROKEN: list[tuple[str, Any]] = [
    ("model", {"version": 1, "components": 5}),
    ("model", {"version": 1, "components": [None]}),
    ("model", {"version": 1, "components": [{"name": "A", "states": [{}], "transitions": []}]}),
    ("model", {"version": 1, "robot": "R", "components": [], "commands": "all"}),
    ("state", {"version": 1, "commands": 3}),
    ("state", {"version": 1, "commands": [], "components": None, "variables": None}),
    ("state", {"version": 1, "commands": [], "components": {}, "variables": {}}),
    ("event", {"version": 1, "outcome": "applied"}),
    ("event", {"version": 1, "outcome": "applied", "event": {}, "number": 10**6, "time": "now"}),
]


@pytest.mark.parametrize(("topic", "document"), BROKEN)
def test_what_cannot_be_shown_is_told_and_the_rest_goes_on(
    topic: str, document: Any, told: Told, heard: Heard, browser: Browser
) -> None:
    getattr(heard, topic)(json.dumps(document))
    fault = "document.getElementById('fault')"
    browser.sees(f"!{fault}.hidden && {fault}.textContent.includes('{topic}')")
    before = told.state["components"]
    while told.state["components"]["Motor"] == before["Motor"]:
        told.step()
    told.to(heard)
    browser.sees(is_in("Motor", told.state["components"]["Motor"]))
    browser.sees(f"{fault}.hidden")


@pytest.mark.parametrize(
    "text", ["", "{", "[]", "null", '{"version":2,"commands":[]}', "[" * 100_000, '{"commands":[]}']
)
def test_what_is_no_document_is_left_alone(text: str) -> None:
    hub = Hub()
    heard = Heard("/strange", hub)
    before = hub.follow().take(0)
    for listener in (heard.model, heard.state, heard.event):
        listener(text)
    assert hub.follow().take(0) == before


def test_a_node_that_begins_again_with_another_model(
    told: Told, heard: Heard, browser: Browser
) -> None:
    for _ in range(20):
        told.step()
        told.to(heard)
    browser.sees("page.events.length === 20")
    other = Told(line_follower())
    names = {"Motor": "Engine", "moving": "turning"}
    other.step()
    event = {**other.event, "time": told.event["time"] + 1}
    other.model, other.state = renamed(other.model, names), renamed(other.state, names)
    # Its state may come before its model: the topics are independent.
    heard.event(json.dumps(event))
    heard.state(json.dumps(other.state))
    browser.sees("page.number === 1")
    heard.model(json.dumps(other.model))
    browser.sees(is_in("Engine", other.state["components"]["Engine"]))
    browser.sees("page.events.length === 1")
    assert browser.run("return document.querySelectorAll('[data-component=Motor]').length") == 0


@pytest.mark.parametrize("width", [1280, 320])
def test_the_state_of_a_large_automaton_is_in_sight(
    width: int, told: Told, heard: Heard, browser: Browser
) -> None:
    sensor = told.model["components"][0]
    state, transition = sensor["states"][0], sensor["transitions"][0]
    names = [f"state_{i}" for i in range(12)]
    ways = [(a, b) for i, a in enumerate(names) for b in (names[i - 1], names[(5 * i + 2) % 12])]
    sensor["states"] = [{**state, "name": n, "initial": n == names[0]} for n in names]
    sensor["transitions"] = [{**transition, "from": a, "to": b} for a, b in ways]
    browser.look(width, 900)
    lit = "page.cards.get('DistanceSensor').diagram.element.querySelector('.active')"
    for name in names:
        told.state["components"]["DistanceSensor"] = name
        told.to(heard)
        browser.sees(f"{lit}?.textContent === '{name}'")
        left, right, begin, end = browser.run(
            f"const [a, b] = [{lit}, {lit}.closest('.drawing')].map((e) => e.getBoundingClientRect());"
            "return [a.left, a.right, b.left, b.right]"
        )
        assert begin - 1 <= left and right <= end + 1
    assert browser.run("return document.documentElement.scrollWidth <= innerWidth")
    browser.picture(f"view-automaton-{width}")


@pytest.mark.parametrize("first", ["state", "event"])
def test_a_node_that_begins_again_and_is_heard_late(
    first: str, told: Told, heard: Heard, browser: Browser
) -> None:
    """Its first events are lost, and those that are heard have higher numbers than the last run's."""
    begun = told.state["time"]
    for number in range(1, 4):
        told.step()
        told.event |= {"number": number, "time": begun + number}
        told.state |= {"begun": begun, "number": number, "latest": [told.event]}
        told.to(heard)
    browser.sees("page.events.length === 3 && page.shown.begun === arguments[0]", begun)
    event = {**told.event, "number": 9, "time": begun + 69}
    state = {**told.state, "begun": begun + 60, "number": 9, "latest": [event]}
    for topic in (first, *({"state", "event"} - {first})):
        getattr(heard, topic)(json.dumps(state if topic == "state" else event))
        browser.sees("page.number === 9" if topic == "event" else "page.shown.number === 9")
    assert browser.run("return page.events.map((e) => e.number)") == [9]
