"""A dispatcher calls three controllers: every job is done once, though one of them is killed."""

from __future__ import annotations

import contextlib
from collections.abc import Iterator
from typing import Any

from ros1.stage import Node, Puppet, Stage, event
from ros_support import await_condition

DISPATCHER, CARRIER = "dispatch_controller", "orders_controller"
JOBS = 12


@contextlib.contextmanager
def carrier(stage: Stage, ear: Puppet, number: int) -> Iterator[Node]:
    """A carrier of its own name, and its door is open."""
    names = ("order", "switch", "door", "lamp")
    rules = [f"/{name}:=/carrier{number}/{name}" for name in names]
    with stage.controller(ear, CARRIER, [f"__ns:=/carrier{number}", *rules]) as node:
        ear.publish(f"/carrier{number}/door", "std_msgs/Bool", True)
        node.shows(lambda s: s["variables"]["Door.open"])
        yield node


def done(state: dict[str, Any]) -> int:
    return sum(state["variables"][f"Carrier[{n}].done"] for n in (1, 2, 3))


def served(node: Node) -> int:
    """How many orders a carrier has answered."""
    answers = node.events(event("response", "order", outcome="applied"))
    return len({answer["number"] for answer in answers})  # somebody may have listened twice


def await_served(number: int, *nodes: Node) -> None:
    """The dispatcher may have told of the last answer before its carrier has."""
    await_condition(lambda: sum(map(served, nodes)) >= number, "the answers to all jobs")
    assert sum(map(served, nodes)) == number


def test_jobs_are_shared_by_three_carriers(stage: Stage, puppet: Puppet, ear: Puppet) -> None:
    with contextlib.ExitStack() as stack:
        carriers = [stack.enter_context(carrier(stage, ear, number)) for number in (1, 2, 3)]
        dispatcher = stack.enter_context(stage.controller(ear, DISPATCHER))
        puppet.publish("/job", "std_msgs/Empty", times=JOBS)
        state = dispatcher.shows(lambda s: done(s) == JOBS and not s["variables"]["Jobs.open"])
        assert state["counters"]["errors"] == 0
        await_served(JOBS, *carriers)


def test_a_carrier_is_killed_and_comes_back(stage: Stage, puppet: Puppet, ear: Puppet) -> None:
    """The job that it had is reported as an error, and done by another carrier."""
    with contextlib.ExitStack() as stack:
        first, second = (stack.enter_context(carrier(stage, ear, number)) for number in (1, 2))
        dispatcher = stack.enter_context(stage.controller(ear, DISPATCHER))
        with carrier(stage, ear, 3) as third:
            ear.publish("/carrier3/door", "std_msgs/Bool", False)
            third.shows(lambda s: not s["variables"]["Door.open"], since=ear.mark)
            puppet.publish("/job", "std_msgs/Empty", times=JOBS)
            dispatcher.shows(lambda s: done(s) == JOBS - 1 and not s["variables"]["Jobs.open"])
            third.process.kill()
            third.process.wait()
        state = dispatcher.shows(lambda s: done(s) == JOBS and not s["variables"]["Jobs.open"])
        assert state["counters"]["errors"] >= 1
        await_served(JOBS, first, second)
        with carrier(stage, ear, 3) as again:
            puppet.publish("/job", "std_msgs/Empty", times=JOBS)
            dispatcher.shows(lambda s: done(s) == 2 * JOBS and not s["variables"]["Jobs.open"])
            await_served(2 * JOBS, first, second, again)
