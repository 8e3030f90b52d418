"""A real controller on a roscore, and what its page shows in a browser."""

from __future__ import annotations

import re
import signal
import subprocess
import threading
import time
from collections.abc import Iterator
from http.server import BaseHTTPRequestHandler, ThreadingHTTPServer
from pathlib import Path
from typing import Any

import pytest
import ros_support
from ros1.stage import Node, Puppet, Stage, event
from ros_support import EXAMPLES, Master, Workspace, await_condition, free_port
from view.browser import Browser
from view.watching import Watcher, command_is, is_in, link_says

MODEL = EXAMPLES / "line_follower" / "line_follower.rscd"
NODE = "line_follower_controller"
DISTANCE = ("/distance", "std_msgs/Float32")

pytestmark = pytest.mark.ros


@pytest.fixture
def stage(example_workspace: Workspace, roscore: Master) -> Stage:
    return Stage(example_workspace, roscore)


@pytest.fixture
def puppet(stage: Stage) -> Iterator[Puppet]:
    with stage.puppet() as running:
        yield running


@pytest.fixture
def url(stage: Stage) -> Iterator[str]:
    """The page of a viewer that was there before the controller."""
    command = ("rosrun", "robosc", "view", "--ros", f"/{NODE}", "--port", "0")
    with stage.workspace.start(*command, master=stage.master) as process:
        yield address(process)


def address(process: subprocess.Popen[bytes]) -> str:
    log: Path = process.log  # type: ignore[attr-defined]

    def printed() -> str | None:
        assert process.poll() is None, log.read_text(encoding="utf-8")
        found = re.search(r"http://\S+", log.read_text(encoding="utf-8"))
        return found and found[0]

    return str(await_condition(printed, "the address of the page"))


@pytest.mark.once
def test_the_page_shows_what_the_controller_tells(
    stage: Stage, puppet: Puppet, url: str, browser: Browser
) -> None:
    browser.open(url)
    browser.sees(link_says("waiting for"))
    with stage.controller(puppet, NODE) as node:
        browser.sees(link_says("live"))
        browser.sees("document.getElementById('robot').textContent === 'LineFollower'")
        puppet.do("listen", topic="/vel", type="geometry_msgs/Twist")
        # A sensor that falls silent stops the motor; the page may take longer than that.
        puppet.steadily(*DISTANCE, 1.0)
        node.enters("Motor", "moving")
        browser.sees(is_in("DistanceSensor", "sensing"))
        browser.sees(is_in("Motor", "moving"))
        browser.sees(command_is("move.request", "enabled"))
        reasons_are_those_of_the_topic(browser, node, "stop.request", "LF-2 ")

        puppet.steadily(*DISTANCE, 0.1)
        node.enters("Motor", "stopped")
        browser.sees(is_in("Motor", "stopped"))
        reasons_are_those_of_the_topic(browser, node, "move.request", "LF-1 ")
        puppet.publish("/correction", "std_msgs/Float32", 12.5)
        browser.sees(is_in("LineDetector", "line_found"))
        browser.sees(
            "document.querySelector('[data-component=LineDetector] .variables').innerText.includes('12.5')"
        )
        sent = "document.querySelector('[data-command=\"move.request\"] .sent').textContent"
        browser.sees(f"{sent}.includes('linear: {{x: 0.2')")
        browser.sees("page.times.mean(now()) > 5")
        for name, *look in (("view", 1280, 900), ("view-phone", 360, 1200, "dark")):
            browser.look(*look)
            browser.picture(name)
    browser.sees(link_says("waiting for"))


def test_where_the_page_is_stands_in_diagnostics(puppet: Puppet, url: str) -> None:
    puppet.do("listen", topic="/diagnostics", type="diagnostic_msgs/DiagnosticArray")
    puppet.hears("/diagnostics")
    (status,) = puppet.all_heard("/diagnostics")[0]["status"]
    assert (status["name"], status["message"]) == (f"{NODE}: page", url)


def reasons_are_those_of_the_topic(browser: Browser, node: Node, command: str, words: str) -> None:
    """The page forbids a command by just the requirements that the topic tells, each with the line
    on which it stands in the model."""
    row = f"[data-command='{command}']"
    browser.sees(f"document.querySelector(\"{row}\").dataset.is === 'forbidden'")
    name, _, kind = command.partition(".")
    latest = node.ear.all_heard(f"{node.name}/state")[-1]
    (told,) = (
        c for c in latest["commands"] if (c["event"]["name"], c["event"]["kind"]) == (name, kind)
    )
    lines = [
        f"line {r['place'].rpartition(':')[2]} "
        + "".join(f"{part}: " for part in [", ".join(r.get("because", []))] if part)
        + r["text"]
        for r in told["blocked_by"]
    ]
    assert browser.text(f"{row} .below:last-child") == " ".join(lines)
    source = MODEL.read_text(encoding="utf-8").splitlines()
    numbers = [int(r["place"].rpartition(":")[2]) for r in told["blocked_by"]]
    assert any(words in source[number - 1] for number in numbers)


def test_a_controller_that_begins_again(
    stage: Stage, puppet: Puppet, url: str, browser: Browser
) -> None:
    browser.open(url)
    for _ in range(2):
        mark, begun = puppet.mark, time.time()
        with stage.controller(puppet, NODE) as node:
            browser.sees(link_says("live"))
            stage.master.await_links(node.name)
            puppet.publish(*DISTANCE, 1.0, times=1)
            node.enters("DistanceSensor", "sensing")
            browser.sees(is_in("DistanceSensor", "sensing"))
            # The list holds events of this run only, each once.
            last = node.tells(event("response", "distance"), since=mark)["number"]
            browser.sees("page.number >= arguments[0]", last)
            numbers = browser.run("return page.events.map((e) => e.number)")
            assert numbers == sorted(set(numbers))
            assert browser.run("return page.events[0].time") > begun
        browser.sees(link_says("waiting for"))


def test_a_viewer_outlives_masters(
    example_workspace: Workspace, browser: Browser, tmp_path: Path
) -> None:
    master_to_be = Master(free_port())
    command = ("rosrun", "robosc", "view", "--ros", f"/{NODE}", "--port", "0")
    with example_workspace.start(*command, master=master_to_be) as viewer:
        browser.open(address(viewer))
        browser.sees(link_says("waiting for a master on"))
        for run in ("first", "second"):
            (tmp_path / run).mkdir()
            with ros_support.master(tmp_path / run, master_to_be.port) as running:
                stage = Stage(example_workspace, running)
                with stage.puppet() as puppet, stage.controller(puppet, NODE) as node:
                    browser.sees(link_says("live"))
                    running.await_links(node.name)
                    puppet.publish(*DISTANCE, 1.0, times=1)
                    browser.sees(is_in("DistanceSensor", "sensing"))
                    browser.sees("page.events.some((e) => e.event.name === 'distance')")
            stale = "document.getElementById('stale').textContent"
            browser.sees(f"{stale}.includes('no master on {running.uri}')")
            if run == "first":
                is_asked_in_vain(master_to_be.port)


def is_asked_in_vain(port: int) -> None:
    """For a while, what listens on the master's port is none."""
    asked = []

    class NoMaster(BaseHTTPRequestHandler):
        def log_message(self, format: str, *args: Any) -> None:
            asked.append(args)

    with ThreadingHTTPServer(("127.0.0.1", port), NoMaster) as server:
        thread = threading.Thread(target=server.serve_forever, args=(0.01,))
        thread.start()
        try:
            await_condition(lambda: len(asked) > 3, "questions to the master")
        finally:
            server.shutdown()
            thread.join()


def test_the_viewer_takes_part_in_nothing(
    stage: Stage, puppet: Puppet, url: str, roscore: Master
) -> None:
    with stage.controller(puppet, NODE):
        name = await_condition(
            lambda: next((n for n in nodes(stage) if n.startswith("/robosc_view")), None),
            "the viewer",
        )
        info = stage.workspace.run("rosnode", "info", str(name), master=roscore).stdout
        # Where its page is, and what it listens to.
        told = ["/diagnostics [diagnostic_msgs/DiagnosticArray]"]
        told += [f"/{NODE}/{topic} [std_msgs/String]" for topic in ("events", "model", "state")]
        assert sorted(re.findall(r"\* (/\S+ \[.*\])", info)) == sorted(told)
        assert info.index("/diagnostics") < info.index("Subscriptions:")


def test_who_mistypes_a_name_is_told_which_there_are(stage: Stage, puppet: Puppet) -> None:
    command = ("rosrun", "robosc", "view", "--ros", "/line_folower", "--port", "0")
    with stage.controller(puppet, NODE), stage.workspace.start(*command, master=stage.master) as p:
        port = int(address(p).rstrip("/").rpartition(":")[2])
        watcher = Watcher(port)
        told = f"waiting for /line_folower; also running: /{NODE}"
        watcher.until(lambda w: w.seen.get("status", {}).get("text") == told)
        watcher.close()


def nodes(stage: Stage) -> list[str]:
    return stage.workspace.run("rosnode", "list", master=stage.master).stdout.split()


def test_the_viewer_leaves_the_master_when_it_is_interrupted(stage: Stage, roscore: Master) -> None:
    command = ("rosrun", "robosc", "view", "--ros", f"/{NODE}", "--port", "0")
    with stage.workspace.start(*command, master=roscore) as process:
        address(process)
        await_condition(lambda: "robosc_view" in " ".join(nodes(stage)), "the viewer")
        process.send_signal(signal.SIGINT)
        assert process.wait(60) == 130
    assert "robosc_view" not in " ".join(nodes(stage))
    assert "Traceback" not in process.log.read_text(encoding="utf-8")  # type: ignore[attr-defined]
