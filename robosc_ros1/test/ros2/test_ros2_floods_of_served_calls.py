"""Very many calls and goals at once: each is answered or refused, none twice, and nothing is kept."""

from __future__ import annotations

import pytest
from ros2.ros2_support import Peer, Process
from ros2.test_ros2_calls_of_the_robot import DONE, ORDER, open_door
from ros2.test_ros2_calls_of_the_robot import TYPE as SWITCH
from ros2.test_ros2_goals_of_the_robot import NAME, SUCCEEDED, TYPE, step
from ros_support import resident

CALLS = 500
AT_ONCE = 50
ROUNDS = 3


def flood_calls(peer: Peer) -> int:
    """How many were answered; the others were refused."""
    calls = {"name": ORDER, "type": SWITCH, "data": {"data": True}}
    answers = peer.order("flood", seconds=300.0, **calls, count=CALLS, at_once=AT_ONCE)
    done = sum(answer == DONE for answer in answers)
    assert done and done + sum("is busy" in a["message"] for a in answers) == CALLS == len(answers)
    return done


def flood_goals(peer: Peer) -> int:
    goals = {"name": NAME, "type": TYPE, "data": {"x": [2.5], "y": [0.0]}}
    ends = peer.order("flood_goals", seconds=300.0, **goals, count=CALLS, at_once=AT_ONCE)
    done = ends.count(SUCCEEDED)
    assert done and done + ends.count(None) == CALLS == len(ends)
    return done


@pytest.mark.parametrize("model", ["orders", "missions"])
def test_five_hundred_leave_nothing_behind(
    watcher: Peer, nodes: dict[str, Process], model: str
) -> None:
    """The memory of nodes after each five hundred is that before, but for a tenth; the first have it
    grow to what it needs."""
    robot = watcher
    if model == "orders":
        flood, name = flood_calls, "order"
        open_door(robot)
    else:
        flood, name = flood_goals, "mission"
        step(robot, 3)
    variable = {"orders": "Door.open", "missions": "Legs.steps"}[model]
    for node in nodes:
        robot.expect_state(node, lambda s: s["variables"][variable])
    done, sizes = 0, []
    for _ in range(ROUNDS):
        done += flood(robot)
        sizes.append([resident(process.popen.pid) for process in nodes.values()])
    assert all(after <= 1.1 * before for before, after in zip(*sizes[-2:], strict=True)), sizes
    first, *_ = nodes
    counted = {"refused": ROUNDS * CALLS - done, "mismatches": 0}
    robot.expect_state(first, lambda s: counted.items() <= s["counters"].items())
    for node in nodes:
        robot.expect_state(node, lambda s: s["communications"][name] == "idle")
