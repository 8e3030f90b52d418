"""A controller and a supervisor as shadows of a controller that drives, on a real roscore."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from typing import Any
from xmlrpc.client import ServerProxy

import pytest
from emit.golden_packages import package_of
from ros1.stage import Puppet, Stage, event
from ros_support import Master, Workspace
from runtime.schemas import validate

from robosc.emit.write.writer import write

LIGHT, FLOAT = "std_msgs/Int16", "std_msgs/Float32"
CONTROLLER = "lantern_controller"
SHADOW = "/shadow/lantern_controller"
BESIDE = ("__ns:=/shadow", "kindle:=/kindle", "~snuff:=/lantern_controller/snuff")


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
    with stage.controller(puppet, CONTROLLER, BESIDE, shadow=True) as shadow:
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
    with stage.controller(puppet, CONTROLLER, BESIDE, shadow=True) as shadow:
        sky.steadily("/brightness", LIGHT, 50)
        shadow.tells(event("response", "brightness"))
        sky.do("steadily", topic="/kindle", type="std_msgs/Empty", fields={})
        told = shadow.tells(event("request", "kindle", outcome="forbidden"))
        assert told["blocked_by"][0]["text"] == "requirement kindle needs Sky.light = dark"


@pytest.fixture(scope="module")
def supervised(make_workspace: Callable[[], Workspace], shared_master: Master) -> Stage:
    workspace = make_workspace()
    for mode in ("controller", "supervisor"):
        write(package_of("thermostat", mode=mode), workspace.folder / "src")
    workspace.build()
    return Stage(workspace, shared_master)


def is_connected(missing: str) -> bool:
    """Whether the shadow has looked who is there, and hears what is sent to the heater."""
    return "/reading" in missing and "/heat" not in missing


def test_the_launch_file_puts_a_shadow_of_the_supervisor_beside_the_controller(
    supervised: Stage,
) -> None:
    node, package = "thermostat_supervisor", "thermostat_controller"
    with (
        supervised.puppet() as robot,
        supervised.workspace.start(
            "roslaunch", node, f"{node}.launch", "shadow:=true",
            f"controller_package:={package}", f"controller_executable:={package}",
            master=supervised.master,
        ),
    ):  # fmt: skip
        for topic in ("events", "state"):
            robot.do("listen", topic=f"/{node}/{topic}", type="std_msgs/String")
        robot.do("listen", topic="/heat", type=FLOAT)
        # The heater is switched on once, which the shadow would miss if it were connected later.
        robot.hears(f"/{node}/state", lambda s: is_connected(str(s["unconnected"])))
        robot.steadily("/reading", FLOAT, 5.0)
        robot.hears("/heat")
        robot.hears(f"/{node}/events", event("request", "heat", seen=True))
        publishers, subscribers, _ = ServerProxy(supervised.master.uri).getSystemState("/test")[2]
        names = {name for name, _ in (*publishers, *subscribers)}
        assert not [name for name in names if name.startswith("/supervised")]
        assert dict(publishers)["/heat"] == ["/controller"]
