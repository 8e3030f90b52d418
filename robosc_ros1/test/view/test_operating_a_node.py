"""The operator's hand in a real browser, on a real controller and its roscore."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest
from ros1.stage import Puppet, Stage, event
from ros_support import Master, Workspace, await_condition
from view.browser import Browser
from view.operators_hand import TOLD, click, send
from view.test_page_follows_a_node import NODE, address
from view.watching import is_in, link_says

pytestmark = pytest.mark.ros


@pytest.fixture
def stage(example_workspace: Workspace, roscore: Master) -> Stage:
    return Stage(example_workspace, roscore)


@pytest.fixture
def puppet(stage: Stage) -> Iterator[Puppet]:
    with stage.puppet() as running:
        running.do("listen", topic="/vel", type="geometry_msgs/Twist")
        yield running


def operated(document: dict[str, Any]) -> bool:
    return bool(document["event"]["kind"] == "operator")


@pytest.mark.once
def test_a_person_holds_steps_and_releases_a_controller_and_sends_to_it(
    stage: Stage, puppet: Puppet, browser: Browser
) -> None:
    words = ("rosrun", "robosc", "view", "--ros", f"/{NODE}", "--port", "0", "--operate")
    # Once the light shows that there is no line, it is no command that may be stepped; nor is to stop,
    # however late a reading comes.
    puppet.do("service", name="/set_light_state", type="robot_common/LightBulbService")
    with (
        stage.workspace.start(*words, "DistanceSensor", master=stage.master) as view,
        stage.controller(puppet, NODE, operate=True, timeout__distance=600.0) as node,
    ):
        node.enters("LightBulb", "known")
        browser.open(address(view))
        browser.sees(link_says("live"))
        assert browser.run("return location.href").endswith("/")  # the token is out of sight
        # What a person sends is an input like any other.
        send(browser, "distance", "nonsense")
        browser.sees(f"{TOLD} !== ''")
        browser.complaints()  # of what was refused
        send(browser, "distance", "1.0")
        node.tells(event("response", "distance", value=1.0))
        browser.sees(f"{TOLD} === ''")

        click(browser, "hold-all")
        node.shows(lambda s: s["stopped"] == "held by the operator")
        browser.sees(
            "document.getElementById('alert').textContent.includes('held by the operator')"
        )
        browser.picture("view-operate")
        mark = puppet.mark
        puppet.steadily("/distance", "std_msgs/Float32", 1.0)
        node.shows(lambda s: s["counters"]["inputs"] > 20, since=mark)
        before = node.shows(lambda s: True, since=puppet.mark)["counters"]["commands"]
        assert before == node.shows(lambda s: True, since=puppet.mark)["counters"]["commands"]

        # One command at a time, and only what is allowed: with nothing near, that is to move.
        mark = puppet.mark
        click(browser, "step")
        node.tells(event("operator", "", value="step", outcome="operated"), since=mark)
        node.shows(lambda s: s["counters"]["commands"] == before + 1, since=mark)
        browser.sees(is_in("Motor", "moving"))
        click(browser, "release")
        node.shows(lambda s: s["counters"]["commands"] > before + 5, since=mark)
        told = [(e["event"]["value"], e["outcome"]) for e in node.events(operated)]
        assert told == [("hold", "operated"), ("step", "operated"), ("release", "operated")]
        log: Path = view.log  # type: ignore[attr-defined]
        for what in ("distance 1.0", "hold", "step", "release"):
            await_condition(lambda what=what: f"operator: {what}\n" in log.read_text("utf-8"), what)


def test_a_node_that_was_not_started_for_it_takes_no_orders(
    stage: Stage, puppet: Puppet, browser: Browser
) -> None:
    words = ("rosrun", "robosc", "view", "--ros", f"/{NODE}", "--port", "0", "--operate")
    with (
        stage.workspace.start(*words, master=stage.master) as view,
        stage.controller(puppet, NODE) as node,
    ):
        browser.open(address(view))
        browser.sees(link_says("live"))
        click(browser, "hold-all")
        browser.sees(f"{TOLD}.includes('operate:=true')")
        browser.complaints()  # of what was refused
        assert node.shows(lambda s: True, since=puppet.mark)["stopped"] is None
