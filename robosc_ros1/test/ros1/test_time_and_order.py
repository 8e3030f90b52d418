"""Silence of sensors, delayed transitions, and topics of several communications, on a roscore."""

from __future__ import annotations

import os
import signal
from typing import Any

import pytest
from ros1.stage import PATIENCE, Node, Puppet, Stage, event, master_pid
from ros_support import Master, Workspace, stopped

NODE = "watch_controller"
NODE_NAME = f"/{NODE}"
SCAN = {"topic": "/scan", "type": "std_msgs/Float32", "fields": {"data": 5.0}}
INT = "std_msgs/Int16"


def count(state: dict[str, Any], name: str) -> int:
    """How often a command was sent."""
    return next(int(c["count"]) for c in state["commands"] if c["event"]["name"] == name)


def drives(node: Node) -> dict[str, Any]:
    """The state in which the scan is fresh and the robot has driven."""
    return node.shows(lambda s: s["communications"]["scan"] == "fresh" and count(s, "drive") > 2)


@pytest.mark.once
def test_a_killed_sensor_stops_the_robot(stage: Stage, ear: Puppet) -> None:
    with stage.controller(ear, NODE) as node:
        ear.do("listen", topic="/halt", type="std_msgs/Empty")
        with stage.puppet() as sensor:
            sensor.begin("publish", **SCAN, times=10_000, rate=50.0)
            drives(node)
            sensor.process.kill()
            silent = node.tells(event("timeout", "scan"))
        heard = node.events(event("response", "scan"))[-1]
        assert silent["time"] - heard["time"] >= 0.49
        # It was not allowed to halt while it drove; now it does, again and again.
        mark = ear.mark
        for _ in range(3):
            node.tells(event("after", "Motor", value="rest->ready"), since=mark)
            node.tells(event("request", "halt"), since=mark)
            mark = ear.mark
        driven = node.events(event("request", "drive"))
        assert driven
        assert all(drive["number"] < silent["number"] for drive in driven)
        assert len(node.events(event("timeout", "scan"))) == 1


def test_a_sensor_that_stood_still_and_comes_back_with_a_burst(stage: Stage, ear: Puppet) -> None:
    with stage.controller(ear, NODE) as node, stage.puppet() as sensor:
        sensor.begin("publish", **SCAN, times=10_000, rate=50.0)
        drives(node)
        with stopped(sensor.process.pid):
            silent = node.tells(event("timeout", "scan"))
            node.tells(event("request", "halt"))
            mark = ear.mark
        node.tells(event("response", "scan"), since=mark)
        node.tells(event("request", "drive"), since=mark)
        node.shows(lambda s: s["communications"]["scan"] == "fresh", since=mark)
        assert node.events(event("timeout", "scan")) == [silent]


def test_scans_that_waited_while_the_node_stood_still_move_nothing(
    stage: Stage, ear: Puppet
) -> None:
    with stage.controller(ear, NODE, rate=50.0) as node, stage.puppet() as sensor:
        sensor.begin("publish", **SCAN, times=100, rate=50.0)
        drives(node)
        silent = node.tells(event("timeout", "scan"))
        mark = ear.mark
        with stopped(node.process.pid):
            sensor.do("publish", **SCAN, times=20, rate=20.0)
        node.shows(lambda s: s["counters"]["inputs"] >= 120, since=mark)
        node.tells(event("timeout", "scan"), since=mark)
        sensor.do("publish", **SCAN)
        driven = node.tells(event("request", "drive"), since=mark)
        scans = [e["number"] for e in node.events(event("response", "scan"))]
        assert len(scans) == 121
        assert silent["number"] < scans[100] < scans[120] < driven["number"]


def test_a_sensor_at_the_edge_of_its_timeout(stage: Stage, ear: Puppet) -> None:
    """On a simulated clock the edge is exact, however slow the machine is.

    The timeout is so long that it does not end by the clock of the machine, while that counts.
    """
    parameters = {"timeout__scan": 3000.0}
    with (
        stage.simulated_time(),
        stage.controller(ear, NODE, **parameters) as node,
        stage.puppet() as sensor,
    ):

        def shows_left(left: float, seconds: float = PATIENCE) -> None:
            """Await a time that is left of the timeout; another one than before."""
            node.shows(
                lambda s: abs(s["clocks"].get("scan", 0.0) - left) < 0.001,
                since=mark,
                seconds=seconds,
            )

        def clock(*times: float) -> None:
            for seconds in times:
                sensor.do("clock", seconds=seconds, to=NODE_NAME)

        mark = ear.mark
        sensor.do("publish", **SCAN)
        node.tells(event("response", "scan"), since=mark)
        # Time begins late, and that is no silence. A node that sees only the second of the two takes
        # it for the beginning, and the first one then for a jump back, which begins anew.
        for last in (False, False, True):
            mark = ear.mark
            clock(1000.0, 1000.1)
            try:
                shows_left(2999.9, seconds=PATIENCE if last else 3.0)
                break
            except AssertionError:
                assert not last
        for turn in range(5):
            mark = ear.mark
            sensor.do("publish", **SCAN)
            shows_left(3000.0)
            clock(1000.1 + 2999.99 * (turn + 1))
            shows_left(0.01)
        assert node.events(event("timeout", "scan")) == []
        # A bag that is played anew: the clock jumps back, and the timeout starts anew.
        mark = ear.mark
        clock(500.0)
        shows_left(3000.0)
        clock(3499.95)
        shows_left(0.05)
        assert node.events(event("timeout", "scan")) == []
        clock(3500.01)
        node.tells(event("timeout", "scan"))


def test_a_bag_at_double_speed(stage: Stage, ear: Puppet) -> None:
    """Four seconds of a bag in two: the scan comes every 0.1 s of it, and then no more."""
    parameters = {"timeout__scan": 2.0}
    with stage.simulated_time(), stage.controller(ear, NODE, **parameters) as node:
        with stage.puppet() as bag:
            bag.begin("play", **SCAN, to=NODE_NAME, start=100.0, seconds=4.0, speed=2.0, end=6.5)
            silent = node.tells(event("timeout", "scan"))
        heard = node.events(event("response", "scan"))
        assert len(heard) == 40
        assert silent["number"] > heard[-1]["number"]
        # Two seconds of the bag are one of the wall; the bag went on for 2.5 s of its own.
        assert silent["time"] - heard[-1]["time"] > 0.9
        assert len(node.events(event("timeout", "scan"))) == 1


def test_silence_is_noticed_and_shown_with_two_clocks(stage: Stage, ear: Puppet) -> None:
    """They are 20 ms apart, as of a simulator and of a bag that is played beside it."""
    with stage.simulated_time(), stage.controller(ear, NODE) as node:
        node.shows(lambda s: any("has not begun" in f for f in s["faults"]))
        with stage.puppet() as bag, stage.puppet() as simulator:
            for puppet, start in ((bag, 100.0), (simulator, 99.98)):
                play = {"start": start, "seconds": 1.0, "speed": 1.0, "end": 8.0}
                puppet.begin("play", **SCAN, to=NODE_NAME, **play)
            node.tells(event("timeout", "scan"))
            for text in ("all publish /clock", "steps back again and again"):
                node.shows(lambda s, text=text: any(text in f for f in s["faults"]))


def test_silence_is_noticed_before_ros_time_begins(stage: Stage, ear: Puppet) -> None:
    """Nobody publishes /clock, but the robot moves."""
    with stage.simulated_time(), stage.controller(ear, NODE) as node:
        with stage.puppet() as sensor:
            sensor.begin("publish", **SCAN, times=10_000, rate=50.0)
            node.shows(lambda s: s["communications"]["scan"] == "fresh")
            mark = ear.mark
        node.tells(event("timeout", "scan"), since=mark)
        node.shows(lambda s: any("has not begun" in f for f in s["faults"]))


def test_silence_is_noticed_after_the_clock_died(stage: Stage, ear: Puppet) -> None:
    with stage.simulated_time(), stage.controller(ear, NODE) as node:
        with stage.puppet() as bag:
            play = {"start": 100.0, "seconds": 1e4, "speed": 1.0, "end": 1e4}
            bag.begin("play", **SCAN, to=NODE_NAME, **play)
            node.shows(lambda s: s["communications"]["scan"] == "fresh" and not s["faults"])
            mark = ear.mark
        node.tells(event("timeout", "scan"), since=mark)
        node.shows(lambda s: any("stands still" in f for f in s["faults"]))


def test_silence_is_noticed_without_a_master(
    generated_workspace: Workspace, roscore: Master
) -> None:
    stage = Stage(generated_workspace, roscore)
    with stage.puppet() as ear, stage.controller(ear, NODE) as node, stage.puppet() as sensor:
        sensor.begin("publish", **SCAN, times=10_000, rate=50.0)
        drives(node)
        os.kill(master_pid(roscore), signal.SIGKILL)
        mark = ear.mark
        node.tells(event("request", "drive"), since=mark)
        sensor.process.kill()
        node.tells(event("timeout", "scan"))
        mark = ear.mark
        node.tells(event("request", "halt"), since=mark)


def test_a_topic_of_two_communications_is_one_input(
    stage: Stage, puppet: Puppet, ear: Puppet
) -> None:
    with stage.controller(ear, NODE, publish_events=False) as node:
        puppet.publish("/way", INT, -1)
        before = node.shows(lambda s: s["variables"]["Way.back"])
        mark = ear.mark
        signs = {"fields": {"data": 1}, "other": {"data": -1}}
        puppet.do("publish", topic="/way", type=INT, **signs, times=10_000, rate=2000.0)
        after = node.shows(lambda s: s["counters"]["inputs"] >= 20_002, since=mark)
        assert after["counters"]["dropped"] == 0
        assert count(after, "stay") == count(before, "stay")
