"""A dispatcher calls three controllers on real rclpy: each job is done once, though one is killed."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any

import pytest
from fleets import JOBS, MISSION, ORDER, Fleet, Job, check_a_carrier_killed, check_three_carriers
from ros2.ros2_support import Graph, Peer, Process

Start = Callable[..., Process]


class Ros2Fleet(Fleet):
    parts = tuple(
        f"_action/{part}"
        for part in ("send_goal", "cancel_goal", "get_result", "feedback", "status")
    )

    def __init__(self, job: Job, folder: Path, robot: Peer, start: Start) -> None:
        super().__init__(job, folder)
        self._robot = robot
        self._start = start
        self._carriers: dict[int, Process] = {}

    def dispatch(self) -> None:
        self._start(self.job.dispatcher, qos__job__reliability="reliable")
        self._robot.watch(self.job.dispatcher)
        # A carrier that is not connected yet would fail the job that it is given.
        missing = f"/{self.job.name}"
        self.shows(self.job.dispatcher, lambda s: missing not in str(s["unconnected"]))

    def give_jobs(self) -> None:
        self._robot.publish("/job", "std_msgs/msg/Empty", [{}] * JOBS)

    def start_carrier(self, number: int, rules: Sequence[str], log: Path, again: bool) -> None:
        reliable = {f"qos__{self.job.topic}__reliability": "reliable"}
        process = self._start(self.job.carrier, rules, event_log=str(log), **reliable)
        self._carriers[number] = process
        self._robot.watch(self.name(number))

    def tell(self, number: int, told: object, again: bool) -> None:
        # The one that was killed may still be taken for a subscriber, so this one is told repeatedly.
        how: dict[str, Any] = {"do": "repeat"} if again else {"do": "publish", "matched": 1}
        topic, type_ = f"/carrier{number}/{self.job.topic}", f"std_msgs/msg/{self.job.type}"
        self._robot.order(**how, name=topic, type=type_, qos={}, data={"data": told})

    def kill(self, number: int) -> None:
        process = self._carriers[number]
        process.popen.kill()
        process.wait()

    def shows(self, node: str, where: Callable[[dict[str, Any]], object]) -> dict[str, Any]:
        return self._robot.expect_state(node, where)


@pytest.fixture(params=[ORDER, MISSION], ids=["services", "actions"])
def fleet(request: pytest.FixtureRequest, graph: Graph, controller: Start, tmp_path: Path) -> Fleet:
    return Ros2Fleet(request.param, tmp_path, graph.peer(), controller)


def test_jobs_are_shared_by_three_carriers(fleet: Fleet) -> None:
    check_three_carriers(fleet)


def test_a_carrier_is_killed_and_comes_back(fleet: Fleet) -> None:
    check_a_carrier_killed(fleet)
