"""Goals that a supervisor passes on to a server that is slow to say, or never says, what it has.

The test is the server: what it tells is published by hand.
"""

from __future__ import annotations

import signal
from collections.abc import Iterator
from typing import Any

import pytest
from ros1.stage import Node, Puppet, Stage, event
from ros_support import await_condition

GO, GUARDED = "/go", "/supervised/go"
ACTIVE, PREEMPTED, SUCCEEDED, RECALLING, RECALLED = 1, 2, 3, 7, 8
LISTENED = {"/goal": "robot_common/NavigateActionGoal", "/cancel": "actionlib_msgs/GoalID"}
RESULT = "robot_common/NavigateActionResult"


@pytest.fixture
def server(stage: Stage) -> Iterator[Puppet]:
    with stage.puppet() as running:
        for part, type_ in LISTENED.items():
            running.do("listen", topic=GO + part, type=type_)
        yield running


@pytest.fixture
def other(stage: Stage) -> Iterator[Puppet]:
    with stage.puppet() as running:
        running.do("listen", topic=GUARDED + "/result", type=RESULT)
        yield running


@pytest.fixture
def guard(stage: Stage, server: Puppet, other: Puppet) -> Iterator[Node]:
    """The supervisor of a courier that is wanted, connected with the server."""
    with stage.controller(other, "courier_supervisor") as node:
        begins(server)
        node.shows(lambda s: s["variables"]["Desk.open"])
        yield node


def begins(server: Puppet) -> None:
    """Have the server be there, and somebody want goals."""
    is_there(server)
    server.publish("/wanted", "std_msgs/Bool", True)


def is_there(server: Puppet) -> None:
    lists(server)
    for part in ("feedback", "result"):
        type_ = f"robot_common/NavigateAction{part.title()}"
        server.do("publish", topic=f"{GO}/{part}", type=type_, fields={})


def goal_id(name: str) -> dict[str, Any]:
    return {"id": name, "stamp": {"secs": 1, "nsecs": 0}}


def sends(other: Puppet, name: str) -> None:
    fields = {"goal_id": goal_id(name)}
    other.do("publish", topic=GUARDED + "/goal", type=LISTENED["/goal"], fields=fields)


def cancels(other: Puppet, name: str) -> None:
    topic = GUARDED + "/cancel"
    other.do("publish", topic=topic, type=LISTENED["/cancel"], fields={"id": name})


def lists(server: Puppet, **goals: int) -> None:
    """Have the server's status list goals from now on."""
    listed = [{"goal_id": goal_id(name), "status": status} for name, status in goals.items()]
    fields = {"status_list": listed}
    server.do(
        "steadily", topic=f"{GO}/status", type="actionlib_msgs/GoalStatusArray", fields=fields
    )


def ends(server: Puppet, name: str, status: int) -> None:
    fields = {"status": {"goal_id": goal_id(name), "status": status}}
    server.do("publish", topic=f"{GO}/result", type=RESULT, fields=fields)


def asked(server: Puppet, name: str) -> None:
    """The server has got a goal."""
    server.hears(GO + "/goal", lambda message: message["goal_id"]["id"] == name)


def cancelled(server: Puppet, name: str, times: int) -> None:
    """The server was asked so many times to end a goal; the supervisor repeats it each second."""

    def often() -> bool:
        heard = [message["id"] for message in server.all_heard(GO + "/cancel")]
        return heard.count(name) >= times

    await_condition(often, f"{times} cancels of {name}")


def shows(guard: Node, phase: str, since: int = 0) -> None:
    guard.shows(lambda s: s["communications"]["go"] == phase, since=since)


def answer_of(other: Puppet, name: str) -> int:
    heard = other.hears(
        GUARDED + "/result", lambda message: message["status"]["goal_id"]["id"] == name
    )
    status: int = heard["status"]["status"]
    return status


def test_a_cancelled_goal_that_its_server_has_not_listed_goes_on(
    guard: Node, server: Puppet, other: Puppet
) -> None:
    sends(other, "late")
    asked(server, "late")
    server.publish("/wanted", "std_msgs/Bool", False)
    guard.shows(lambda s: not s["variables"]["Desk.open"], since=other.mark)
    cancels(other, "late")
    cancelled(server, "late", 5)
    shows(guard, "cancelling", since=other.mark)
    lists(server, late=RECALLING)
    mark = other.mark
    ends(server, "late", RECALLED)
    shows(guard, "idle", since=mark)
    assert answer_of(other, "late") == RECALLED


def test_a_replaced_goal_that_its_server_has_not_listed_goes_on(
    guard: Node, server: Puppet, other: Puppet
) -> None:
    sends(other, "first")
    asked(server, "first")
    sends(other, "second")
    asked(server, "second")
    lists(server, second=ACTIVE)
    cancelled(server, "first", 5)
    lists(server, second=SUCCEEDED)
    ends(server, "second", SUCCEEDED)
    assert answer_of(other, "second") == SUCCEEDED
    cancelled(server, "first", 7)
    shows(guard, "busy", since=other.mark)
    mark = other.mark
    ends(server, "first", PREEMPTED)
    guard.tells(event("response", "go"), since=mark)
    shows(guard, "idle", since=mark)


def test_a_goal_whose_cancel_came_first_is_not_passed_on(
    guard: Node, server: Puppet, other: Puppet
) -> None:
    """The server would forget the cancel after some time, and then carry the goal out."""
    cancels(other, "overtaken")
    cancelled(server, "overtaken", 1)
    sends(other, "overtaken")
    assert answer_of(other, "overtaken") == RECALLED
    guard.tells(event("error", "go"))
    sends(other, "next")
    asked(server, "next")
    assert [m["goal_id"]["id"] for m in server.all_heard(GO + "/goal")] == ["next"]


def test_a_goal_that_ended_without_a_result_ends_for_the_controller(
    guard: Node, server: Puppet, other: Puppet
) -> None:
    sends(other, "first")
    asked(server, "first")
    lists(server, first=SUCCEEDED)
    guard.tells(event("error", "go"))
    assert answer_of(other, "first") == 4  # aborted: there is nothing that it succeeded with


def test_a_goal_that_ends_with_its_supervisor_ends_for_the_controller(
    guard: Node, server: Puppet, other: Puppet
) -> None:
    sends(other, "last")
    asked(server, "last")
    lists(server, last=ACTIVE)
    shows(guard, "busy")
    guard.process.send_signal(signal.SIGINT)
    cancelled(server, "last", 1)
    ends(server, "last", PREEMPTED)
    assert answer_of(other, "last") == PREEMPTED


def test_a_server_that_has_only_the_cancel_of_a_goal_is_another_one(
    guard: Node, server: Puppet, other: Puppet
) -> None:
    """The cancel reached it before its first status came."""
    sends(other, "first")
    asked(server, "first")
    lists(server, first=ACTIVE)
    cancels(other, "first")
    cancelled(server, "first", 2)
    lists(server, first=RECALLING)
    guard.tells(event("error", "go", reason="lost"))


def test_a_controller_takes_such_a_server_for_another_one(stage: Stage, server: Puppet) -> None:
    with stage.puppet() as ear, stage.controller(ear, "courier_controller") as node:
        begins(server)
        name = server.hears(GO + "/goal")["goal_id"]["id"]
        lists(server, **{name: ACTIVE})
        server.publish("/wanted", "std_msgs/Bool", False)
        cancelled(server, name, 2)
        lists(server, **{name: RECALLING})
        node.tells(event("error", "go", reason="lost"))


def test_a_goal_may_still_come_to_a_server_that_has_forgotten_its_cancel(
    guard: Node, server: Puppet, other: Puppet
) -> None:
    """actionlib forgets it after five seconds; what is large, or goes another way, may take longer."""
    sends(other, "late")
    asked(server, "late")
    server.publish("/wanted", "std_msgs/Bool", False)
    guard.shows(lambda s: not s["variables"]["Desk.open"], since=other.mark)
    cancels(other, "late")
    cancelled(server, "late", 2)
    lists(server, late=RECALLING)
    lists(server)
    cancelled(server, "late", 5)
    lists(server, late=RECALLING)
    lists(server)
    shows(guard, "cancelling", since=other.mark)
    lists(server, late=ACTIVE)
    mark = other.mark
    ends(server, "late", PREEMPTED)
    guard.tells(event("cancelled", "go"), since=mark)
    assert guard.events(event("error", "go")) == []


def test_so_it_may_for_a_controller(stage: Stage, server: Puppet) -> None:
    with stage.puppet() as ear, stage.controller(ear, "courier_controller") as node:
        begins(server)
        name = server.hears(GO + "/goal")["goal_id"]["id"]
        server.publish("/wanted", "std_msgs/Bool", False)
        cancelled(server, name, 1)
        lists(server, **{name: RECALLING})
        lists(server)
        cancelled(server, name, 3)
        node.shows(lambda s: s["communications"]["go"] == "cancelling", since=ear.mark)
        lists(server, **{name: ACTIVE})
        cancelled(server, name, 5)
        mark = ear.mark
        ends(server, name, PREEMPTED)
        node.tells(event("cancelled", "go"), since=mark)


def test_a_cancelled_goal_that_a_new_server_does_not_have_ends_for_the_controller(
    stage: Stage, guard: Node, server: Puppet, other: Puppet
) -> None:
    """It may not wait for the goal to come: that was on its way to another server."""
    sends(other, "late")
    asked(server, "late")
    server.publish("/wanted", "std_msgs/Bool", False)
    guard.shows(lambda s: not s["variables"]["Desk.open"], since=other.mark)
    cancels(other, "late")
    cancelled(server, "late", 1)
    server.process.kill()
    with stage.puppet() as new:
        is_there(new)
        lists(new, late=RECALLING)
        lists(new)
        guard.tells(event("cancelled", "go"))
        assert answer_of(other, "late") == RECALLED
