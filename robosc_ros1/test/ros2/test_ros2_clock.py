"""Simulated time on real rclpy: the pace follows it, however it runs; deadlines do not."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import pytest
from ros2.ros2_support import Graph, Peer, Process

Start = Callable[..., Process]
READING = "robosc_testing/msg/Reading"


def commands(robot: Peer, count: int, inputs: int) -> None:
    """Wait for these counters, and no others that come before them."""
    state = robot.expect_state("guarded_arm", lambda s: s["counters"]["inputs"] == inputs)
    if state["counters"]["commands"] < count:
        state = robot.expect_state("guarded_arm", lambda s: s["counters"]["commands"] >= count)
    assert state["counters"]["commands"] == count


def charge(robot: Peer) -> None:
    """Something that makes the controller look, and is no reason for a command."""
    robot.publish("charge", "std_msgs/msg/Int16", {"data": 50})


def set_clock(robot: Peer, seconds: float, count: int) -> None:
    """Have it be so late, and wait until so many commands were sent in all.

    The clock is best effort, so it may have to be said again.
    """
    sec, part = divmod(seconds, 1.0)
    clock = {"clock": {"sec": int(sec), "nanosec": round(part * 1e9)}}

    def told(patience: float) -> dict[str, Any]:
        robot.publish("/clock", "rosgraph_msgs/msg/Clock", clock)
        return robot.expect_state(
            "guarded_arm", lambda s: s["counters"]["commands"] >= count, patience
        )

    for _ in range(10):
        try:
            assert told(3.0)["counters"]["commands"] == count
            return
        except AssertionError as error:
            if "within 3 s" not in str(error):
                raise
    pytest.fail("the clock is not heard")


def test_simulated_time_stands_still_runs_and_jumps(graph: Graph, controller: Start) -> None:
    controller(use_sim_time=True, timeout__lock=0.5)
    robot = graph.peer()
    robot.watch("guarded_arm")
    # It stands at 0: what becomes allowed is sent, nothing is repeated.
    robot.publish("person", READING, {"valid": True, "distance": 0.5})
    commands(robot, 2, inputs=1)
    charge(robot)
    commands(robot, 2, inputs=2)
    # It runs from 0: both commands are due again, once.
    set_clock(robot, 0.11, 4)
    set_clock(robot, 0.25, 6)
    # It jumps far ahead, and back.
    set_clock(robot, 500.0, 8)
    set_clock(robot, 1.0, 8)
    charge(robot)
    commands(robot, 8, inputs=3)
    set_clock(robot, 1.11, 10)
    # It stands still: a call has its deadline by the time of the wall.
    robot.publish("go", "std_msgs/msg/Bool", {"data": True})
    robot.expect_state("guarded_arm", lambda s: s["counters"]["errors"] == 1)
