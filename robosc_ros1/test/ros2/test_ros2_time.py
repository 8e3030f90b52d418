"""Silence of sensors and delayed transitions on real rclpy: the watch of ``golden/models``.

What is judged are the controller's own events, each with its time; the sensors are processes.
"""

from __future__ import annotations

import json
import signal
from collections.abc import Callable
from typing import Any

import pytest
from ros2.ros2_support import Graph, Peer, Process
from ros_support import stopped

Start = Callable[..., Process]
Json = dict[str, Any]
NODE = "watch_controller"
SCAN = {"name": "/scan", "type": "std_msgs/msg/Float32", "data": {"data": 5.0}}
RELIABLE = {"qos__scan__reliability": "reliable"}


@pytest.fixture
def ear(graph: Graph) -> Peer:
    """Hears what the controller tells and shows."""
    peer = graph.peer("ear")
    peer.watch(NODE)
    peer.subscribe(f"{NODE}/events", "std_msgs/msg/String")
    peer.subscribe("/halt", "std_msgs/msg/Empty")
    return peer


def told(ear: Peer, kind: str, name: str, **more: Any) -> Json:
    """Wait for an event of the controller; it and those before it are used up."""
    documents: list[Json] = []

    def fits(data: Json) -> bool:
        documents.append(json.loads(data["data"]))
        event = documents[-1]["event"]
        return (event["kind"], event["name"]) == (kind, name) and all(
            event[key] == value for key, value in more.items()
        )

    ear.expect("message", where=fits, name=f"{NODE}/events")
    return documents[-1]


def count(state: Json, name: str) -> int:
    """How often a command was sent."""
    return next(int(c["count"]) for c in state["commands"] if c["event"]["name"] == name)


def drives(ear: Peer) -> None:
    """The scan is fresh, and the robot has driven."""
    ear.expect_state(
        NODE, lambda s: s["communications"]["scan"] == "fresh" and count(s, "drive") > 2
    )


@pytest.mark.once
def test_a_killed_sensor_stops_the_robot(graph: Graph, controller: Start, ear: Peer) -> None:
    controller(NODE)
    sensor = graph.peer("sensor")
    sensor.order("repeat", **SCAN, qos={})
    drives(ear)
    sensor.process.signal(signal.SIGKILL)
    sensor.process.wait()
    told(ear, "timeout", "scan")
    state = ear.expect_state(NODE, lambda s: s["communications"]["scan"] == "silent")
    driven = count(state, "drive")
    for _ in range(3):
        told(ear, "after", "Motor", value="rest->ready")
        told(ear, "request", "halt")
    state = ear.expect_state(NODE, lambda s: count(s, "halt") >= 3)
    assert count(state, "drive") == driven


def test_a_sensor_that_stood_still_and_comes_back(
    graph: Graph, controller: Start, ear: Peer
) -> None:
    controller(NODE)
    sensor = graph.peer("sensor")
    sensor.order("repeat", **SCAN, qos={})
    drives(ear)
    with stopped(sensor.process.popen.pid):
        told(ear, "timeout", "scan")
        told(ear, "request", "halt")
    told(ear, "response", "scan")
    told(ear, "request", "drive")
    drives(ear)


def test_bursts_after_silence(graph: Graph, controller: Start, ear: Peer) -> None:
    """Of a reliable topic no message is lost, however many come at once."""
    controller(NODE, **RELIABLE, qos__scan__depth=1000)
    sensor = graph.peer("sensor")
    told(ear, "request", "halt")  # so its events are heard
    driven = 0
    for _ in range(3):
        sensor.publish(SCAN["name"], SCAN["type"], [SCAN["data"]] * 300)
        for _ in range(300):
            told(ear, "response", "scan")
        told(ear, "timeout", "scan")
        state = ear.expect_state(
            NODE, lambda s, n=driven: s["communications"]["scan"] == "silent" and count(s, "drive") > n
        )  # fmt: skip
        driven = count(state, "drive")
    assert state["counters"]["dropped"] == 0


def test_scans_that_waited_while_the_node_stood_still_move_nothing(
    graph: Graph, controller: Start, ear: Peer
) -> None:
    """Twenty scans wait for a node that stands still: it takes them, and drives on the next.

    The order of the controller's events, by their numbers, is what counts.
    """
    process = controller(NODE, **RELIABLE, qos__scan__depth=100)
    sensor, first = graph.peer("sensor"), graph.peer("first")
    scans = [SCAN["data"]] * 20
    # So that the sensor is connected before the node stands still.
    sensor.publish(SCAN["name"], SCAN["type"], SCAN["data"])
    first.order("repeat", **SCAN, qos={})
    drives(ear)
    first.process.signal(signal.SIGKILL)
    first.process.wait()
    silent = told(ear, "timeout", "scan")["number"]
    with stopped(process.popen.pid):
        sensor.order("publish", **{**SCAN, "data": scans}, matched=1, qos={}, rate=20.0)
    taken = [told(ear, "response", "scan")["number"] for _ in scans]
    # What waited is too old to be fresh, once it is all taken.
    over = told(ear, "timeout", "scan")["number"]
    sensor.order("repeat", **SCAN, qos={})
    driven = told(ear, "request", "drive")["number"]
    assert silent < taken[0] < taken[-1] < over < driven


class Clock:
    """The clock of a graph with simulated time. It is best effort, so it may have to be said again."""

    def __init__(self, peer: Peer, ear: Peer) -> None:
        self._peer = peer
        self._ear = ear

    def show(self, *times: float, left: float, within: float = 0.001) -> None:
        """Have it be so late, one after the other, until so many seconds are left of the scan's
        timeout; which must be others than before."""
        for _ in range(10):
            for seconds in times:
                sec, part = divmod(seconds, 1.0)
                message = {"clock": {"sec": int(sec), "nanosec": round(part * 1e9)}}
                self._peer.publish("/clock", "rosgraph_msgs/msg/Clock", message)
            try:
                self._ear.expect_state(
                    NODE, lambda s: abs(s["clocks"].get("scan", 0.0) - left) < within, 3.0
                )
                return
            except AssertionError as error:
                if "within 3 s" not in str(error):
                    raise
        pytest.fail("the clock is not heard")


def test_a_sensor_at_the_edge_of_its_timeout(graph: Graph, controller: Start, ear: Peer) -> None:
    """On a simulated clock the edge is exact, however slow the machine is.

    The timeout is so long that it does not end by the clock of the machine, while that counts.
    """
    controller(NODE, use_sim_time=True, timeout__scan=3000.0, **RELIABLE)
    sensor = graph.peer("sensor")
    clock = Clock(sensor, ear)
    sensor.publish(SCAN["name"], SCAN["type"], SCAN["data"])
    ear.expect_state(NODE, lambda s: s["communications"]["scan"] == "fresh")
    # Time begins late, and that is no silence. Should the first of the two times be lost, the
    # second one begins it, and the first comes again as a jump back, which starts the timeout anew.
    clock.show(1000.0, 1000.1, left=2999.9)
    for turn in range(5):
        sensor.publish(SCAN["name"], SCAN["type"], SCAN["data"])
        ear.expect_state(NODE, lambda s: abs(s["clocks"]["scan"] - 3000.0) < 0.001)
        clock.show(1000.1 + 2999.99 * (turn + 1), left=0.01)
    heard = ear.events("message", name=f"{NODE}/events")
    assert not [e for e in heard if "timeout" in e["data"]["data"]]
    # A bag that is played anew: the clock jumps back, and the timeout starts anew.
    clock.show(500.0, left=3000.0)
    clock.show(3500.6, left=0.0)
    told(ear, "timeout", "scan")


def test_a_bag_at_double_speed(graph: Graph, controller: Start, ear: Peer) -> None:
    """Four seconds of a bag in two: the scan comes every 0.1 s of it, and then no more."""
    controller(NODE, use_sim_time=True, timeout__scan=2.0, **RELIABLE)
    bag = graph.peer("bag")
    bag.order("play", **SCAN, start=100.0, until=4.0, speed=2.0, end=6.5)
    told(ear, "timeout", "scan")
    ear.expect_state(
        NODE, lambda s: s["communications"]["scan"] == "silent" and count(s, "drive") > 2
    )
    later = [json.loads(e["data"]["data"]) for e in ear.events("message", name=f"{NODE}/events")]
    assert not [e for e in later if e["event"]["name"] == "scan"]


def test_silence_is_noticed_before_ros_time_begins(
    graph: Graph, controller: Start, ear: Peer
) -> None:
    """Nobody publishes /clock, but the robot moves."""
    controller(NODE, use_sim_time=True, **RELIABLE)
    sensor = graph.peer("sensor")
    sensor.order("repeat", **SCAN, qos={})
    ear.expect_state(NODE, lambda s: s["communications"]["scan"] == "fresh")
    sensor.process.signal(signal.SIGKILL)
    told(ear, "timeout", "scan")
    ear.expect_state(NODE, lambda s: any("has not begun" in f for f in s["faults"]))


def test_silence_is_noticed_after_the_clock_died(
    graph: Graph, controller: Start, ear: Peer
) -> None:
    controller(NODE, use_sim_time=True, **RELIABLE)
    bag = graph.peer("bag")
    bag.begin("play", **SCAN, start=100.0, until=1e4, speed=1.0, end=1e4)
    ear.expect_state(NODE, lambda s: s["communications"]["scan"] == "fresh" and not s["faults"])
    bag.process.signal(signal.SIGKILL)
    told(ear, "timeout", "scan")
    ear.expect_state(NODE, lambda s: any("stands still" in f for f in s["faults"]))


def test_silence_is_noticed_and_shown_with_two_clocks(
    graph: Graph, controller: Start, ear: Peer
) -> None:
    """They are 20 ms apart, as of a simulator and of a bag that is played beside it."""
    controller(NODE, use_sim_time=True, **RELIABLE)
    ear.expect_state(NODE, lambda s: any("has not begun" in f for f in s["faults"]))
    peers = [graph.peer("bag"), graph.peer("simulator")]
    for peer, start in zip(peers, (100.0, 99.98), strict=True):
        peer.begin("play", **SCAN, start=start, until=1.0, speed=1.0, end=8.0)
    told(ear, "timeout", "scan")
    wanted = ("/bag and /simulator all publish /clock", "steps back again and again")
    ear.expect_state(NODE, lambda s: all(any(text in f for f in s["faults"]) for text in wanted))


def test_a_topic_of_two_communications_is_one_input(
    graph: Graph, controller: Start, ear: Peer
) -> None:
    """The sign changes 1,000 times; between two of them it is never neither."""
    controller(NODE, qos__ahead__reliability="reliable", qos__ahead__depth=1000)
    robot = graph.peer("robot")
    way = {"name": "/way", "type": "std_msgs/msg/Int16"}
    robot.publish(**way, data={"data": -1})
    before = ear.expect_state(NODE, lambda s: s["variables"]["Way.back"])
    signs = [{"data": 1 - 2 * (number % 2)} for number in range(1000)]
    robot.order("publish", **way, data=signs, matched=1, qos={}, rate=2000.0)
    heard = before["counters"]["inputs"] + 2 * len(signs)
    after = ear.expect_state(NODE, lambda s: s["counters"]["inputs"] >= heard)
    assert after["counters"]["dropped"] == 0
    assert count(after, "stay") == count(before, "stay")


def test_use_sim_time_may_be_set_while_the_node_runs(
    graph: Graph, controller: Start, ear: Peer
) -> None:
    controller(NODE, timeout__scan=3000.0, **RELIABLE)
    sensor = graph.peer("sensor")
    sensor.publish(SCAN["name"], SCAN["type"], SCAN["data"])
    ear.expect_state(NODE, lambda s: s["communications"]["scan"] == "fresh")
    sensor.order("set_parameter", node=NODE, name="use_sim_time", value=True)
    ear.expect_state(NODE, lambda s: any("use_sim_time was changed" in f for f in s["faults"]))
    clock = Clock(sensor, ear)
    # The change starts the timeout anew; the clock, which begins later, does not do so again.
    clock.show(1e6, 1e6 + 1000.0, left=1900.0, within=100.0)
    sensor.publish(SCAN["name"], SCAN["type"], SCAN["data"])
    ear.expect_state(NODE, lambda s: abs(s["clocks"]["scan"] - 3000.0) < 0.001)
    clock.show(1e6 + 3999.5, left=0.5)
    clock.show(1e6 + 4000.5, left=0.0)
    told(ear, "timeout", "scan")
