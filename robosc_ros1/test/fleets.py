"""A dispatcher that has three carriers do jobs, each a controller of its own, on either ROS."""

from __future__ import annotations

import json
from abc import ABC, abstractmethod
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from ros_support import await_condition

__all__ = [
    "JOBS",
    "MISSION",
    "ORDER",
    "Fleet",
    "Job",
    "check_a_carrier_killed",
    "check_three_carriers",
]

JOBS = 12

State = dict[str, Any]


@dataclass(frozen=True)
class Job:
    """How a dispatcher has a job done: by calling ``name``. A carrier hears its ``topic``, and shows
    what it has heard in ``variable``: having heard ``ready`` it does what it is called for, and having
    heard ``held`` it goes on with it for good. ``renamed`` are all other names that a carrier uses."""

    dispatcher: str
    carrier: str
    name: str
    topic: str
    type: str
    variable: str
    ready: object
    held: object
    renamed: Sequence[str]


ORDER = Job(
    dispatcher="dispatch_controller",
    carrier="orders_controller",
    name="order",
    topic="door",
    type="Bool",
    variable="Door.open",
    ready=True,
    held=False,
    renamed=("switch", "lamp"),
)
MISSION = Job(
    dispatcher="fleet_controller",
    carrier="missions_controller",
    name="mission",
    topic="step",
    type="Int16",
    variable="Legs.steps",
    ready=3,
    held=1,
    renamed=("fault", "lamp"),
)


class Fleet(ABC):
    """A dispatcher and carriers, watched by somebody who is never killed."""

    parts: Sequence[str]
    """The topics and services of an action."""

    def __init__(self, job: Job, folder: Path) -> None:
        self.job = job
        self._folder = folder
        self._logs: list[Path] = []  # of the carriers, the killed ones, too

    @abstractmethod
    def dispatch(self) -> None:
        """Start the dispatcher, until it is connected to the carriers that are there."""

    @abstractmethod
    def give_jobs(self) -> None: ...

    @abstractmethod
    def start_carrier(self, number: int, rules: Sequence[str], log: Path, again: bool) -> None: ...

    @abstractmethod
    def tell(self, number: int, told: object, again: bool) -> None:
        """Tell a carrier something on its topic."""

    @abstractmethod
    def kill(self, number: int) -> None: ...

    @abstractmethod
    def shows(self, node: str, where: Callable[[State], object]) -> State: ...

    def carrier(self, number: int, told: object, again: bool = False) -> None:
        """Start a carrier that is told something. ``again``: one of this name was killed, whom others
        may still take for alive."""
        job, space = self.job, f"/carrier{number}"
        names = (job.topic, job.name, *job.renamed, *(f"{job.name}/{part}" for part in self.parts))
        rules = [f"__ns:={space}", *(f"/{name}:={space}/{name}" for name in names)]
        self._logs.append(self._folder / f"{len(self._logs)}.jsonl")
        self.start_carrier(number, rules, self._logs[-1], again)
        self.tell(number, told, again)
        self.shows(self.name(number), lambda s: s["variables"][job.variable] == told)

    def have_done(self, count: int) -> State:
        """Wait until so many jobs are done, and none is open."""

        def are_done(state: State) -> bool:
            values = state["variables"]
            done = sum(values[f"Carrier[{n}].done"] for n in (1, 2, 3))
            return bool(done == count and not values["Jobs.open"])

        return self.shows(self.job.dispatcher, are_done)

    def have_answered(self, count: int) -> None:
        """Wait until the carriers together have logged so many answers, which are all."""

        def answers() -> int:
            lines = [line for log in self._logs for line in log.read_text("utf-8").splitlines()]
            events = [json.loads(line)["event"] for line in lines if line.startswith("{")]
            return sum((e["kind"], e["name"]) == ("response", self.job.name) for e in events)

        await_condition(lambda: answers() >= count, "the answers in the logs")
        assert answers() == count

    def name(self, number: int) -> str:
        return f"/carrier{number}/{self.job.carrier}"


def check_three_carriers(fleet: Fleet) -> None:
    for number in (1, 2, 3):
        fleet.carrier(number, fleet.job.ready)
    fleet.dispatch()
    fleet.give_jobs()
    assert fleet.have_done(JOBS)["counters"]["errors"] == 0
    fleet.have_answered(JOBS)


def check_a_carrier_killed(fleet: Fleet) -> None:
    """The job that it was on is reported as an error, and done by another carrier."""
    fleet.carrier(1, fleet.job.ready)
    fleet.carrier(2, fleet.job.ready)
    fleet.carrier(3, fleet.job.held)
    fleet.dispatch()
    fleet.give_jobs()
    fleet.have_done(JOBS - 1)
    fleet.shows(fleet.name(3), lambda s: s["communications"][fleet.job.name] == "busy")
    fleet.kill(3)
    assert fleet.have_done(JOBS)["counters"]["errors"] >= 1
    fleet.have_answered(JOBS)
    fleet.carrier(3, fleet.job.ready, again=True)
    fleet.give_jobs()
    fleet.have_done(2 * JOBS)
    fleet.have_answered(2 * JOBS)
