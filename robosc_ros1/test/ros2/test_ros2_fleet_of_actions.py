"""A dispatcher sends three controllers on missions on real rclpy: each is done once, or reported."""

from __future__ import annotations

from pathlib import Path

import pytest
from ros2.fleets import JOBS, Fleet, Job, Start
from ros2.ros2_support import Graph

PARTS = ("send_goal", "cancel_goal", "get_result", "feedback", "status")
MISSION = Job(
    dispatcher="fleet_controller",
    carrier="missions_controller",
    name="mission",
    topic="step",
    type="std_msgs/msg/Int16",
    variable="Legs.steps",
    renamed=("fault", "lamp", *(f"mission/_action/{part}" for part in PARTS)),
)
STEPS = 3
"""After so many steps a mission is done."""


@pytest.fixture
def fleet(graph: Graph, controller: Start, tmp_path: Path) -> Fleet:
    return Fleet(MISSION, graph.peer(), controller, tmp_path)


def test_missions_are_shared_by_three_carriers(fleet: Fleet) -> None:
    for number in (1, 2, 3):
        fleet.carrier(number, STEPS)
    fleet.dispatch()
    fleet.give_jobs()
    assert fleet.have_done(JOBS)["counters"]["errors"] == 0
    fleet.have_answered(JOBS)


def test_a_carrier_is_killed_on_its_mission_and_comes_back(fleet: Fleet) -> None:
    """The mission that it was on is reported as an error, and done by another carrier."""
    fleet.carrier(1, STEPS)
    fleet.carrier(2, STEPS)
    third = fleet.carrier(3, 1)
    fleet.dispatch()
    fleet.give_jobs()
    fleet.have_done(JOBS - 1)
    fleet.shows(3, lambda s: s["communications"]["mission"] == "busy")
    third.popen.kill()
    third.wait()
    assert fleet.have_done(JOBS)["counters"]["errors"] >= 1
    fleet.have_answered(JOBS)
    fleet.carrier(3, STEPS, again=True)
    fleet.give_jobs()
    fleet.have_done(2 * JOBS)
    fleet.have_answered(2 * JOBS)
