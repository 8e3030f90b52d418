"""A dispatcher and three carriers on real rclpy, which it gives jobs to do."""

from __future__ import annotations

import json
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from ros2.ros2_support import Peer, Process
from ros_support import await_condition

__all__ = ["JOBS", "Fleet", "Job", "Start"]

Start = Callable[..., Process]
JOBS = 12


@dataclass(frozen=True)
class Job:
    """How a dispatcher has a job done: the call is ``name``. A carrier hears its ``topic``, and
    shows what it has heard in ``variable``; ``renamed`` are all other names that a carrier uses."""

    dispatcher: str
    carrier: str
    name: str
    topic: str
    type: str
    variable: str
    renamed: Sequence[str]


class Fleet:
    """A dispatcher and carriers, watched by somebody who is never killed."""

    def __init__(self, job: Job, robot: Peer, start: Start, folder: Path) -> None:
        self._job = job
        self._robot = robot
        self._start = start
        self._folder = folder
        self._logs: list[Path] = []  # of the carriers, the killed ones, too

    def dispatch(self) -> None:
        job = self._job
        self._start(job.dispatcher, qos__job__reliability="reliable")
        self._robot.watch(job.dispatcher)
        # A carrier that is not connected yet would fail the job that it is given.
        self._robot.expect_state(
            job.dispatcher, lambda s: f"/{job.name}" not in str(s["unconnected"])
        )

    def carrier(self, number: int, told: object, again: bool = False) -> Process:
        """A carrier that is told something. ``again``: one of this name was killed, whom others may
        still take for alive, so that this one is told more than once."""
        job, space = self._job, f"/carrier{number}"
        rules = [f"/{name}:={space}/{name}" for name in (job.topic, *job.renamed)]
        self._logs.append(self._folder / f"{len(self._logs)}.jsonl")
        parameters = {
            "event_log": str(self._logs[-1]),
            f"qos__{job.topic}__reliability": "reliable",
        }
        process = self._start(job.carrier, [f"__ns:={space}", *rules], **parameters)
        self._robot.watch(self._name(number))
        self.tell(number, told, again)
        return process

    def tell(self, number: int, told: object, again: bool = False) -> None:
        job = self._job
        matched = {} if again else {"matched": 1}
        topic = {"name": f"/carrier{number}/{job.topic}", "type": job.type, "qos": {}}
        do = "repeat" if again else "publish"
        self._robot.order(do, **topic, data={"data": told}, **matched)
        self.shows(number, lambda s: s["variables"][job.variable] == told)

    def shows(self, number: int, where: Callable[[dict[str, Any]], object]) -> None:
        self._robot.expect_state(self._name(number), where)

    def give_jobs(self) -> None:
        self._robot.publish("/job", "std_msgs/msg/Empty", [{}] * JOBS)

    def have_done(self, count: int) -> dict[str, Any]:
        """Wait until so many jobs are done, and none is open."""

        def are_done(state: dict[str, Any]) -> bool:
            values = state["variables"]
            done = sum(values[f"Carrier[{n}].done"] for n in (1, 2, 3))
            return bool(done == count and not values["Jobs.open"])

        return self._robot.expect_state(self._job.dispatcher, are_done)

    def have_answered(self, count: int) -> None:
        """Wait until the carriers together have logged so many answers, which are all."""

        def answers() -> int:
            lines = [line for log in self._logs for line in log.read_text("utf-8").splitlines()]
            events = [json.loads(line)["event"] for line in lines if line.startswith("{")]
            return sum((e["kind"], e["name"]) == ("response", self._job.name) for e in events)

        await_condition(lambda: answers() >= count, "the answers in the logs")
        assert answers() == count

    def _name(self, number: int) -> str:
        return f"/carrier{number}/{self._job.carrier}"
