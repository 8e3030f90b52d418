"""A dispatcher calls three controllers on a roscore: each job is done once, though one is killed."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from contextlib import ExitStack
from pathlib import Path
from typing import Any

import pytest
from fleets import JOBS, MISSION, ORDER, Fleet, Job, check_a_carrier_killed, check_three_carriers
from ros1.stage import Node, Puppet, Stage


class Ros1Fleet(Fleet):
    parts = ("goal", "cancel", "status", "feedback", "result")

    def __init__(self, job: Job, folder: Path, robot: Puppet, stage: Stage) -> None:
        super().__init__(job, folder)
        self._robot = robot
        self._stage = stage
        self._nodes: dict[str, tuple[Node, int, ExitStack]] = {}

    def _start(self, name: str, package: str, *rules: str, **parameters: Any) -> None:
        until, since = ExitStack(), self._robot.mark
        node = until.enter_context(
            self._stage.controller(self._robot, package, rules, **parameters)
        )
        self._nodes[name] = node, since, until

    def dispatch(self) -> None:
        self._start(self.job.dispatcher, self.job.dispatcher)

    def give_jobs(self) -> None:
        self._robot.publish("/job", "std_msgs/Empty", times=JOBS)

    def start_carrier(self, number: int, rules: Sequence[str], log: Path, again: bool) -> None:
        self._start(self.name(number), self.job.carrier, *rules, event_log=log)

    def tell(self, number: int, told: object, again: bool) -> None:
        topic = f"/carrier{number}/{self.job.topic}"
        self._robot.publish(topic, f"std_msgs/{self.job.type}", told)

    def kill(self, number: int) -> None:
        node, _, until = self._nodes.pop(self.name(number))
        node.process.kill()
        until.close()

    def shows(self, node: str, where: Callable[[dict[str, Any]], object]) -> dict[str, Any]:
        running, since, _ = self._nodes[node]
        return running.shows(where, since=since)

    def close(self) -> None:
        for _, _, until in self._nodes.values():
            until.close()


@pytest.fixture(params=[ORDER, MISSION], ids=["services", "actions"])
def fleet(
    request: pytest.FixtureRequest, stage: Stage, ear: Puppet, tmp_path: Path
) -> Iterator[Fleet]:
    running = Ros1Fleet(request.param, tmp_path, ear, stage)
    yield running
    running.close()


def test_jobs_are_shared_by_three_carriers(fleet: Fleet) -> None:
    check_three_carriers(fleet)


def test_a_carrier_is_killed_and_comes_back(fleet: Fleet) -> None:
    check_a_carrier_killed(fleet)
