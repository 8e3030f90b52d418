"""A dispatcher calls three controllers on real rclpy: every job is done once, though one is killed."""

from __future__ import annotations

from pathlib import Path

import pytest
from ros2.fleets import JOBS, Fleet, Job, Start
from ros2.ros2_support import Graph

ORDER = Job(
    dispatcher="dispatch_controller",
    carrier="orders_controller",
    name="order",
    topic="door",
    type="std_msgs/msg/Bool",
    variable="Door.open",
    renamed=("order", "switch", "lamp"),
)


@pytest.fixture
def fleet(graph: Graph, controller: Start, tmp_path: Path) -> Fleet:
    return Fleet(ORDER, graph.peer(), controller, tmp_path)


def test_jobs_are_shared_by_three_carriers(fleet: Fleet) -> None:
    for number in (1, 2, 3):
        fleet.carrier(number, True)
    fleet.dispatch()
    fleet.give_jobs()
    assert fleet.have_done(JOBS)["counters"]["errors"] == 0
    fleet.have_answered(JOBS)


def test_a_carrier_is_killed_and_comes_back(fleet: Fleet) -> None:
    """The job that it had is reported as an error, and done by another carrier."""
    fleet.carrier(1, True)
    fleet.carrier(2, True)
    third = fleet.carrier(3, True)
    fleet.tell(3, False)
    fleet.dispatch()
    fleet.give_jobs()
    fleet.have_done(JOBS - 1)
    fleet.shows(3, lambda s: s["communications"]["order"] == "busy")
    third.popen.kill()
    third.wait()
    assert fleet.have_done(JOBS)["counters"]["errors"] >= 1
    fleet.have_answered(JOBS)
    fleet.carrier(3, True, again=True)
    fleet.give_jobs()
    fleet.have_done(2 * JOBS)
    fleet.have_answered(2 * JOBS)
