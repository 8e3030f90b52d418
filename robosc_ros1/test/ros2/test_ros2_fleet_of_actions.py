"""A dispatcher sends three controllers on missions on real rclpy: each is done once, or reported."""

from __future__ import annotations

import json
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest
from ros2.ros2_support import Graph, Peer, Process
from ros_support import await_condition

Start = Callable[..., Process]
DISPATCHER, CARRIER = "fleet_controller", "missions_controller"
JOBS = 12
PARTS = ("send_goal", "cancel_goal", "get_result", "feedback", "status")
RENAMED = ("step", "fault", "lamp", *(f"mission/_action/{part}" for part in PARTS))


class Fleet:
    """A dispatcher and carriers, watched by somebody who is never killed."""

    def __init__(self, robot: Peer, start: Start, folder: Path) -> None:
        self._robot = robot
        self._start = start
        self._folder = folder
        self._logs: list[Path] = []  # of the carriers, the killed ones, too

    def dispatch(self) -> None:
        self._start(DISPATCHER, qos__job__reliability="reliable")
        self._robot.watch(DISPATCHER)
        # A carrier that is not connected yet would fail the mission that it is given.
        self._robot.expect_state(DISPATCHER, lambda s: "/mission" not in str(s["unconnected"]))

    def carrier(self, number: int, steps: int = 3, again: bool = False) -> Process:
        """A carrier; a mission is done after three steps. ``again``: one of this name was killed,
        whom others may still take for alive, so that this one is told of its steps repeatedly."""
        space = f"/carrier{number}"
        rules = [f"/{name}:={space}/{name}" for name in RENAMED]
        self._logs.append(self._folder / f"{len(self._logs)}.jsonl")
        parameters = {"event_log": str(self._logs[-1]), "qos__step__reliability": "reliable"}
        process = self._start(CARRIER, [f"__ns:={space}", *rules], **parameters)
        self._robot.watch(_name(number))
        matched = {} if again else {"matched": 1}
        topic = {"name": f"{space}/step", "type": "std_msgs/msg/Int16", "qos": {}}
        do = "repeat" if again else "publish"
        self._robot.order(do, **topic, data={"data": steps}, **matched)
        self.shows(number, lambda s: s["variables"]["Legs.steps"] == steps)
        return process

    def shows(self, number: int, where: Callable[[dict[str, Any]], object]) -> None:
        self._robot.expect_state(_name(number), where)

    def give_jobs(self) -> None:
        self._robot.publish("/job", "std_msgs/msg/Empty", [{}] * JOBS)

    def have_done(self, count: int) -> dict[str, Any]:
        """Wait until so many missions are done, and none is open."""

        def are_done(state: dict[str, Any]) -> bool:
            values = state["variables"]
            done = sum(values[f"Carrier[{n}].done"] for n in (1, 2, 3))
            return bool(done == count and not values["Jobs.open"])

        return self._robot.expect_state(DISPATCHER, are_done)

    def have_answered(self, count: int) -> None:
        """Wait until the carriers together have logged so many answers, which are all."""

        def answers() -> int:
            lines = [line for log in self._logs for line in log.read_text("utf-8").splitlines()]
            events = [json.loads(line)["event"] for line in lines if line.startswith("{")]
            return sum((e["kind"], e["name"]) == ("response", "mission") for e in events)

        await_condition(lambda: answers() >= count, "the answers in the logs")
        assert answers() == count


def _name(number: int) -> str:
    return f"/carrier{number}/{CARRIER}"


@pytest.fixture
def fleet(graph: Graph, controller: Start, tmp_path: Path) -> Fleet:
    return Fleet(graph.peer(), controller, tmp_path)


def test_missions_are_shared_by_three_carriers(fleet: Fleet) -> None:
    for number in (1, 2, 3):
        fleet.carrier(number)
    fleet.dispatch()
    fleet.give_jobs()
    assert fleet.have_done(JOBS)["counters"]["errors"] == 0
    fleet.have_answered(JOBS)


def test_a_carrier_is_killed_on_its_mission_and_comes_back(fleet: Fleet) -> None:
    """The mission that it was on is reported as an error, and done by another carrier."""
    fleet.carrier(1)
    fleet.carrier(2)
    third = fleet.carrier(3, steps=1)
    fleet.dispatch()
    fleet.give_jobs()
    fleet.have_done(JOBS - 1)
    fleet.shows(3, lambda s: s["communications"]["mission"] == "busy")
    third.popen.kill()
    third.wait()
    assert fleet.have_done(JOBS)["counters"]["errors"] >= 1
    fleet.have_answered(JOBS)
    fleet.carrier(3, again=True)
    fleet.give_jobs()
    fleet.have_done(2 * JOBS)
    fleet.have_answered(2 * JOBS)
