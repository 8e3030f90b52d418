"""A generated monitor beside a faulty controller, on a real roscore."""

from __future__ import annotations

import json
from collections.abc import Callable, Iterator
from typing import Any
from xmlrpc.client import ServerProxy

import pytest
from emit.golden_packages import package_of
from ros1.stage import Puppet, Stage, event
from ros_support import Master, Workspace
from runtime.schemas import validate

from robosc.emit.write.writer import write

NODE = "/lantern_monitor"
FINDINGS = f"{NODE}/findings"
LIGHT = "std_msgs/Int16"
GUARD = 'return self.sky_light != "dark"\n'


@pytest.fixture(scope="module")
def watched_workspace(make_workspace: Callable[[], Workspace]) -> Workspace:
    """A lantern's monitor, its controller, and one that snuffs in the dark."""
    workspace = make_workspace()
    write(package_of("lantern", mode="monitor"), workspace.folder / "src")
    write(package_of("lantern"), workspace.folder / "src")
    faulty = "faulty_lantern"
    write(package_of("lantern", name=faulty), workspace.folder / "src")
    module = workspace.folder / f"src/{faulty}/src/{faulty}/controller.py"
    source = module.read_text(encoding="utf-8")
    assert source.count(GUARD) == 1
    module.write_text(source.replace(GUARD, "return True\n"), encoding="utf-8")
    workspace.build()
    return workspace


@pytest.fixture
def watched(watched_workspace: Workspace, shared_master: Master) -> Stage:
    return Stage(watched_workspace, shared_master)


@pytest.fixture
def listener(watched: Stage) -> Iterator[Puppet]:
    with watched.puppet() as running:
        running.do("listen", topic=FINDINGS, type="std_msgs/String")
        yield running


@pytest.fixture
def sky(watched: Stage) -> Iterator[Puppet]:
    with watched.puppet() as running:
        yield running


def findings(listener: Puppet) -> list[Any]:
    documents = [json.loads(m["data"]) for m in listener.all_heard(FINDINGS)]
    for document in documents:
        validate(document, "finding")
    return documents


def span(listener: Puppet, ended: bool) -> Any:
    """The time in which nothing could be judged, as it was told when it began or ended."""

    def is_meant(message: Any) -> bool:
        event = json.loads(message["data"])["event"]
        return event["kind"] == "span" and (event["value"]["end"] is not None) is ended

    return json.loads(listener.hears(FINDINGS, is_meant)["data"])["event"]["value"]


NOTHING = "this node sends nothing"

# Where the monitor hears what the controller calls its own.
OWN = ("~snuff:=/lantern_controller/snuff",)


@pytest.mark.once
def test_a_faulty_controller_is_found(watched: Stage, sky: Puppet, listener: Puppet) -> None:
    with watched.controller(listener, "lantern_monitor") as monitor:
        sky.steadily("/brightness", LIGHT, 5)
        monitor.tells(event("response", "brightness"))
        with watched.controller(sky, "faulty_lantern", OWN):
            listener.hears(FINDINGS)
            monitor.tells(event("request", "snuff", outcome="forbidden"))
    told = findings(listener)
    assert {(t["sort"], t["event"]["name"]) for t in told} == {("violation", "snuff")}
    (reason,) = told[0]["reasons"]
    assert reason["text"] == "requirement Sky.light = dark disables snuff"
    assert reason["because"] == ["Sky.light is dark"]


def test_a_right_controller_is_not(watched: Stage, sky: Puppet, listener: Puppet) -> None:
    with watched.controller(listener, "lantern_monitor") as monitor:
        sky.steadily("/brightness", LIGHT, 5)
        monitor.tells(event("response", "brightness"))
        mark = listener.mark
        with watched.controller(sky, "lantern_controller"):
            for _ in range(3):
                monitor.tells(event("request", "kindle", seen=True), since=mark)
                mark = listener.mark
                sky.steadily("/brightness", LIGHT, 50)
                monitor.tells(event("request", "snuff", seen=True), since=mark)
                mark = listener.mark
                sky.steadily("/brightness", LIGHT, 5)
        state = monitor.shows(lambda s: s["counters"]["commands"] >= 6)
        assert state["counters"]["forbidden"] == state["counters"]["mismatches"] == 0
    assert findings(listener) == []


def test_who_sees_nothing_says_nothing(watched: Stage, sky: Puppet, listener: Puppet) -> None:
    """Nobody publishes the brightness, which decides; then somebody does."""
    with watched.controller(listener, "lantern_monitor", operate=True) as monitor:
        sky.do("steadily", topic="/kindle", type="std_msgs/Empty", fields={})
        monitor.tells(event("request", "kindle", outcome="undecided"))
        state = monitor.shows(lambda s: s["counters"]["undecided"] > 1)
        assert "/brightness" in state["not_judging"]
        assert state["counters"]["commands"] == state["counters"]["forbidden"] == 0
        assert span(listener, ended=False)["commands"] == 1
        sky.steadily("/brightness", LIGHT, 50)
        assert span(listener, ended=True)["commands"] > 1
        monitor.shows(lambda s: s["not_judging"] is None)
        monitor.tells(event("request", "kindle", outcome="forbidden"))
        listener.hears(FINDINGS, lambda f: json.loads(f["data"])["sort"] == "violation")
        for order in ("hold", "step", "release"):
            sky.publish(f"{NODE}/operate", "std_msgs/String", order)
            monitor.tells(event("operator", "", outcome="refused", detail=NOTHING))
    findings(listener)  # all are as the schema says


JUDGED = "    def is_allowed(self, command: ScheduledCommand, seen: Seen | None = None) -> bool:\n"


def test_its_own_test_finds_what_a_monitor_overlooks(watched_workspace: Workspace) -> None:
    package = watched_workspace.folder / "src/lantern_monitor/src/lantern_monitor"
    module = package / "_runtime/judge/seen.py"
    source = module.read_text(encoding="utf-8")
    assert source.count(JUDGED) == 1
    module.write_text(source.replace(JUDGED, f"{JUDGED}        return True\n"), encoding="utf-8")
    try:
        done = watched_workspace.own_test("lantern_monitor")
    finally:
        module.write_text(source, encoding="utf-8")
    complaint = "(after 'kindle.request'): expected to be sent: nothing; sent: kindle.request"
    assert complaint in done.stdout


def test_it_sends_nothing(watched: Stage, listener: Puppet) -> None:
    with watched.controller(listener, "lantern_monitor"):
        publishers, _, services = ServerProxy(watched.master.uri).getSystemState("/test")[2]
    own = ("/state", "/model", "/events", "/findings")
    topics = {topic for topic, nodes in publishers if NODE in nodes}
    assert topics == {"/diagnostics", "/rosout", *(NODE + name for name in own)}
    assert {s for s, nodes in services if NODE in nodes} == {
        f"{NODE}/get_loggers",
        f"{NODE}/set_logger_level",
    }
