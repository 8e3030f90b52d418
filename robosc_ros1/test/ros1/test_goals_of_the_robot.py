"""Actions of a generated controller: each goal is answered once, or rejected with the reason."""

from __future__ import annotations

import signal
from collections.abc import Iterator
from typing import Any

import pytest
from actionlib_msgs.msg import GoalStatus
from ros1.stage import PATIENCE, Node, Puppet, Stage, event
from ros_support import await_condition

NAME, TYPE = "/mission", "robot_common/OrderAction"
ENDED = (GoalStatus.PREEMPTED, GoalStatus.RECALLED, GoalStatus.LOST)
GOAL = {"x": [2.5], "y": [0.0]}


@pytest.fixture
def node(stage: Stage, ear: Puppet) -> Iterator[Node]:
    with stage.controller(ear, "missions_controller") as running:
        yield running


def send(puppet: Puppet, **fields: Any) -> int:
    """Send a goal; the place of its end."""
    mark = puppet.mark
    puppet.do("send", name=NAME, type=TYPE, fields=GOAL | fields)
    return mark


def end(puppet: Puppet, since: int) -> dict[str, Any]:
    return puppet.wait(lambda line: line.get("ended") == NAME, "the end", since=since)


def accepted(puppet: Puppet, node: Node) -> int:
    mark = send(puppet)
    node.shows(lambda s: s["components"]["Missions"] == "running", since=node.ear.mark)
    return mark


def step(puppet: Puppet, number: int) -> None:
    puppet.publish("/step", "std_msgs/Int16", number)


def is_enabled(state: dict[str, Any], kind: str) -> bool:
    told = ({"kind": kind, "name": "mission", "value": None}, True)
    return told in [(command["event"], command["enabled"]) for command in state["commands"]]


def test_its_status_goes_on_whatever_ros_time_does(stage: Stage, ear: Puppet) -> None:
    """Clients take a server without status for lost."""

    def goes_on() -> None:
        for _ in range(2):
            ear.hears(f"{NAME}/status", since=ear.mark)

    with (
        stage.simulated_time(),
        stage.controller(ear, "missions_controller") as running,
        stage.puppet() as simulator,
    ):
        ear.do("listen", topic=f"{NAME}/status", type="actionlib_msgs/GoalStatusArray")
        goes_on()
        for seconds in (100.0, 100.1, 50.0):
            simulator.do("clock", seconds=seconds, to=running.name)
        goes_on()
        assert "Traceback" not in running.log


@pytest.mark.once
def test_a_goal_is_reported_on_and_answered(puppet: Puppet, node: Node) -> None:
    mark = accepted(puppet, node)
    step(puppet, 2)
    report = puppet.wait(
        lambda line: line.get("progress") == NAME and line["message"]["reached"] == 2,
        "feedback", since=mark,
    )  # fmt: skip
    assert report["message"]["distance"] == 2.5
    node.shows(lambda s: is_enabled(s, "feedback"), since=mark)
    step(puppet, 3)
    ended = end(puppet, mark)
    assert (ended["status"], ended["result"]["reached"]) == (GoalStatus.SUCCEEDED, 3)
    node.shows(lambda s: s["communications"]["mission"] == "idle", since=node.ear.mark)
    again = end(puppet, send(puppet))
    assert again["status"] == GoalStatus.SUCCEEDED


def test_a_goal_that_no_component_takes_is_rejected_with_the_reason(
    puppet: Puppet, node: Node
) -> None:
    ended = end(puppet, send(puppet, x=[-1.0]))
    assert ended["status"] == GoalStatus.REJECTED
    assert "mission is taken where Missions.free and value.x[0] > 0" in ended["text"]
    told = node.tells(event("request", "mission", outcome="refused"))
    assert told["detail"] == ended["text"]


def test_one_goal_at_a_time(stage: Stage, puppet: Puppet, node: Node) -> None:
    mark = accepted(puppet, node)
    with stage.puppet() as other:
        ended = end(other, send(other))
        assert ended["status"] == GoalStatus.REJECTED
        assert ended["text"] == "mission is busy: it serves one call at a time"
    step(puppet, 3)
    assert end(puppet, mark)["status"] == GoalStatus.SUCCEEDED


def test_a_cancelled_goal_ends_as_the_controller_says(puppet: Puppet, node: Node) -> None:
    mark = accepted(puppet, node)
    puppet.do("cancel")
    ended = end(puppet, mark)
    assert ended["status"] == GoalStatus.PREEMPTED
    assert "Missions is in leaving" in ended["text"]
    for kind in ("request", "cancel", "error"):
        node.tells(event(kind, "mission", outcome="applied"))


def test_a_cancel_at_once(puppet: Puppet, node: Node) -> None:
    """actionlib's client itself takes a goal for lost if a status without it comes after its cancel."""
    for _ in range(20):
        mark = puppet.mark
        puppet.begin("send", name=NAME, type=TYPE, fields=GOAL)
        puppet.do("cancel")
        assert end(puppet, mark)["status"] in ENDED
    node.shows(lambda s: s["communications"]["mission"] == "idle", since=node.ear.mark)


def test_an_error_of_the_controller_aborts_the_goal(puppet: Puppet, node: Node) -> None:
    mark = accepted(puppet, node)
    step(puppet, 2)
    node.shows(lambda s: s["variables"]["Legs.steps"] == 2)
    puppet.publish("/fault", "std_msgs/Bool", True)
    ended = end(puppet, mark)
    assert (ended["status"], ended["result"]["reached"]) == (GoalStatus.ABORTED, 2)
    assert "Missions is in running" in ended["text"]


def test_whoever_is_killed_leaves_the_action_to_others(
    stage: Stage, puppet: Puppet, node: Node
) -> None:
    with stage.puppet() as caller:
        accepted(caller, node)
        caller.process.kill()
    step(puppet, 3)
    node.tells(event("response", "mission"))
    assert end(puppet, send(puppet))["status"] == GoalStatus.SUCCEEDED


def test_the_end_of_the_node_aborts_the_goal(puppet: Puppet, node: Node) -> None:
    mark = accepted(puppet, node)
    node.process.send_signal(signal.SIGINT)
    assert node.process.wait(PATIENCE) == 0
    ended = end(puppet, mark)
    assert ended["status"] == GoalStatus.ABORTED
    assert "the node ends" in ended["text"]


def test_the_raw_protocol(puppet: Puppet, node: Node) -> None:
    """A goal by hand, without an id and a stamp, is given both; everything is cancelled by hand."""
    for part, of in (("status", "actionlib_msgs/GoalStatusArray"),
                     ("result", "robot_common/OrderActionResult")):  # fmt: skip
        puppet.do("listen", topic=f"{NAME}/{part}", type=of)
    fields = {"goal": GOAL}
    puppet.do("publish", topic=f"{NAME}/goal", type="robot_common/OrderActionGoal", fields=fields)
    node.shows(lambda s: s["components"]["Missions"] == "running", since=node.ear.mark)
    puppet.do("publish", topic=f"{NAME}/cancel", type="actionlib_msgs/GoalID", fields={})
    result = puppet.hears(f"{NAME}/result")
    assert result["status"]["status"] == GoalStatus.PREEMPTED
    assert result["status"]["goal_id"]["id"]


def test_a_flood_of_goals(puppet: Puppet, node: Node) -> None:
    """Whatever comes at once, each goal is answered or rejected, and none twice."""
    step(puppet, 3)
    mark = puppet.mark
    puppet.do("flood", name=NAME, type=TYPE, fields=GOAL, count=300)

    def ends() -> list[dict[str, Any]]:
        return [line for line in puppet.lines[mark:] if line.get("ended") == NAME]

    await_condition(lambda: len(ends()) == 300, "all ends", 60.0)
    done = [e for e in ends() if e["status"] == GoalStatus.SUCCEEDED]
    rejected = [e for e in ends() if e["status"] == GoalStatus.REJECTED]
    assert len(done) + len(rejected) == 300 and done
    counted = {"refused": len(rejected)}
    node.shows(lambda s: counted.items() <= s["counters"].items())
    answers = event("response", "mission", outcome="applied")
    await_condition(lambda: len(node.events(answers)) == len(done), "their events")
