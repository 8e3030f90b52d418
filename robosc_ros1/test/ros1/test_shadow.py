"""A shadow of a controller that drives, on a real roscore: a mode of the monitor."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any
from xmlrpc.client import ServerProxy

import pytest
from ros1.stage import Puppet, Stage, event
from ros_support import await_condition
from runtime.schemas import validate

LIGHT, FLOAT = "std_msgs/Int16", "std_msgs/Float32"
CONTROLLER, MONITOR = "lantern_controller", "lantern_monitor"
SHADOW = "/lantern_monitor"


@pytest.fixture
def sky(stage: Stage) -> Iterator[Puppet]:
    with stage.puppet() as running:
        yield running


def commands(events: list[Any]) -> list[tuple[str, str]]:
    """The commands that the shadow saw and those that it withheld, in order."""
    told = []
    for document in events:
        validate(document, "event")
        if document.get("seen") or document["outcome"] == "withheld":
            told.append((document["event"]["name"], document["outcome"]))
    return told


@pytest.mark.once
def test_a_shadow_tells_what_the_controller_sends_and_sends_nothing(
    stage: Stage, sky: Puppet, puppet: Puppet
) -> None:
    with stage.controller(puppet, MONITOR, shadow=True) as shadow:
        sky.do("listen", topic="/kindle", type="std_msgs/Empty")
        sky.steadily("/brightness", LIGHT, 50)
        shadow.shows(lambda s: s["variables"]["Sky.light"] == "bright")
        mark = puppet.mark
        sky.steadily("/brightness", LIGHT, 5)
        told = shadow.tells(event("request", "kindle", outcome="withheld"), since=mark)
        # Once at the start, in the dark, and once now: nobody kindles, so it is not told again.
        many = shadow.shows(lambda s: True, since=puppet.mark)["counters"]["inputs"] + 10
        state = shadow.shows(lambda s: s["counters"]["inputs"] > many)
        assert state["counters"]["withheld"] == 2
        assert (told["detail"], state["components"]["Flame"]) == (None, "cold")
        assert sky.all_heard("/kindle") == []
        publishers, _, services = ServerProxy(stage.master.uri).getSystemState("/test")[2]
        topics = {topic for topic, nodes in publishers if SHADOW in nodes}
        own = {f"{SHADOW}/{name}" for name in ("state", "model", "events", "findings")}
        assert topics == {"/diagnostics", "/rosout"} | own
        assert {s for s, nodes in services if SHADOW in nodes} == {
            f"{SHADOW}/get_loggers", f"{SHADOW}/set_logger_level"
        }  # fmt: skip
        with stage.controller(sky, CONTROLLER):
            for light, name, seen in ((50, "snuff", "cold"), (5, "kindle", "burning")) * 2:
                mark = puppet.mark
                sky.steadily("/brightness", LIGHT, light)
                shadow.tells(event("request", name, seen=True, outcome="applied"), since=mark)
                shadow.shows(lambda s, to=seen: s["components"]["Flame"] == to, since=mark)
        state = shadow.shows(lambda s: s["counters"]["commands"] >= 5)
        assert state["counters"]["forbidden"] == state["counters"]["mismatches"] == 0
        told = commands(shadow.events())
    # Which of the two hears of the light first is not known: the shadow may see a command before.
    names = [name for name, outcome in told if outcome == "applied"]
    assert names == ["kindle", "snuff", "kindle", "snuff", "kindle"]
    assert {name for name, outcome in told if outcome == "withheld"} == {"kindle", "snuff"}


def test_what_the_controller_should_not_send_is_told(
    stage: Stage, sky: Puppet, puppet: Puppet
) -> None:
    with stage.controller(puppet, MONITOR, shadow=True) as shadow:
        sky.steadily("/brightness", LIGHT, 50)
        shadow.tells(event("response", "brightness"))
        sky.do("steadily", topic="/kindle", type="std_msgs/Empty", fields={})
        told = shadow.tells(event("request", "kindle", outcome="forbidden"))
        assert told["blocked_by"][0]["text"] == "requirement kindle needs Sky.light = dark"


def test_what_is_preferred_holds_back_as_in_the_controller(
    stage: Stage, sky: Puppet, puppet: Puppet
) -> None:
    """Though a shadow publishes nothing, it knows of the data whether they could be sent."""
    with stage.controller(puppet, "trolley_monitor", shadow=True) as shadow:
        sky.steadily("/near", FLOAT, 2.0)
        first = shadow.tells(event("request", "move", outcome="withheld"))["number"]

        def names() -> list[str]:
            told = shadow.events(lambda e: e["outcome"] == "withheld" and e["number"] > first)
            return [document["event"]["name"] for document in told]

        await_condition(lambda: len(names()) > 10, "what would be sent")
        assert set(names()) == {"move"}
