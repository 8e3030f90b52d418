"""Each reason of an error is reached by a real cause on ROS 2."""

from __future__ import annotations

import json
import signal
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest
from ros2.bed import HERE
from ros2.ros2_support import Graph, Peer, Process
from ros_support import await_condition

GO = ("go", "robot_common/action/Navigate")


def errors_in(log: Path, name: str = "go") -> list[str]:
    """The reasons of the errors in an event log."""
    lines = log.read_text().splitlines() if log.is_file() else []
    found = [json.loads(line) for line in lines]
    return [
        e["reason"] for e in found if (e["event"]["kind"], e["event"]["name"]) == ("error", name)
    ]


@pytest.fixture
def courier(
    graph: Graph, controller: Callable[..., Process], tmp_path: Path
) -> Callable[..., tuple[Peer, Path]]:
    """Starts a courier that is wanted to go somewhere."""

    def start(policy: dict[str, Any] | None, **given: Any) -> tuple[Peer, Path]:
        log = tmp_path / "events.jsonl"
        robot = graph.peer()
        if policy is not None:
            robot.act(*GO, **policy)
        # It is wanted once, which must not be lost.
        given["qos__wanted__reliability"] = "reliable"
        controller("courier_controller", event_log=str(log), **given)
        robot.publish("wanted", "std_msgs/msg/Bool", {"data": True})
        return robot, log

    return start


@pytest.mark.parametrize(
    ("reason", "policy", "given"),
    [
        ("absent", None, {"timeout__go": 0.5}),
        ("rejected", {"accept": False}, {}),
        ("failed", {"end": "abort"}, {}),
        ("timeout", {}, {"goal_timeout__go": 0.5}),
        ("timeout", {"accept": None}, {"timeout__go": 2.0, "server_lost_after": 0.5}),
    ],
)
def test_the_reason_of_an_error(
    courier: Callable[..., tuple[Peer, Path]],
    reason: str,
    policy: dict[str, Any] | None,
    given: dict[str, Any],
) -> None:
    robot, log = courier(policy, **given)
    if given.keys() == {"goal_timeout__go"}:
        goal = robot.expect("goal", name="go")
        robot.expect("cancel", name="go")
        robot.order("tell_server", id=goal["id"], end="canceled")
    await_condition(lambda: errors_in(log)[:1], "an error")
    assert errors_in(log)[0] == reason


def test_an_answer_that_is_not_as_expected_is_refused(
    courier: Callable[..., tuple[Peer, Path]],
) -> None:
    robot, log = courier({})
    goal = robot.expect("goal", name="go")
    robot.order("tell_server", id=goal["id"], end="succeed", result={"distance": 9.0})
    await_condition(lambda: errors_in(log), "an error")
    assert errors_in(log)[0] == "refused"


@pytest.mark.once
def test_a_server_that_vanished_is_lost(
    graph: Graph, courier: Callable[..., tuple[Peer, Path]]
) -> None:
    # How soon a killed process is noticed, is said by itself when it joins.
    profile = str(HERE / "short_lease.xml")
    server = graph.peer("server", FASTRTPS_DEFAULT_PROFILES_FILE=profile)
    server.act(*GO)
    _, log = courier(None, server_lost_after=0.5)
    server.expect("goal", name="go")
    server.process.signal(signal.SIGKILL)
    await_condition(lambda: errors_in(log), "an error")
    assert errors_in(log)[0] == "lost"


def test_what_others_cancel_has_failed(courier: Callable[..., tuple[Peer, Path]]) -> None:
    robot, log = courier({})
    goal = robot.expect("goal", name="go")
    everything = {"type": "action_msgs/srv/CancelGoal", "data": {}}
    robot.order("call", name="go/_action/cancel_goal", **everything)
    robot.expect("cancel", name="go")
    robot.order("tell_server", id=goal["id"], end="canceled")
    await_condition(lambda: errors_in(log), "an error")
    assert errors_in(log)[0] == "failed"


@pytest.mark.parametrize(
    ("reason", "end"),
    [("failed", "abort"), ("refused", "succeed"), ("lost", None)],
)
def test_the_reason_of_an_error_while_cancelling(
    graph: Graph, courier: Callable[..., tuple[Peer, Path]], reason: str, end: str | None
) -> None:
    # How soon a killed process is noticed, is said by itself when it joins.
    profile = str(HERE / "short_lease.xml")
    server = graph.peer("server", FASTRTPS_DEFAULT_PROFILES_FILE=profile)
    server.act(*GO)
    robot, log = courier(None)
    goal = server.expect("goal", name="go")
    robot.publish("wanted", "std_msgs/msg/Bool", {"data": False})
    server.expect("cancel", name="go")
    if end is None:
        server.process.signal(signal.SIGKILL)
    else:
        server.order("tell_server", id=goal["id"], end=end, result={"distance": 9.0})
    await_condition(lambda: errors_in(log), "an error")
    assert errors_in(log) == [reason]


@pytest.mark.parametrize(
    ("reason", "served", "reply"),
    [("absent", False, None), ("refused", True, {"success": False}), ("timeout", True, None)],
)
def test_the_reason_of_an_error_of_a_service(
    graph: Graph,
    controller: Callable[..., Process],
    tmp_path: Path,
    reason: str,
    served: bool,
    reply: dict[str, Any] | None,
) -> None:
    """A service of ROS 2 cannot say that it failed."""
    if served:
        graph.peer().serve("ring", "std_srvs/srv/Trigger", reply)
    log = tmp_path / "events.jsonl"
    controller("bell_controller", event_log=str(log))
    # The server is not there at once for a node that has just begun.
    await_condition(lambda: reason in errors_in(log, "ring"), "the error")
    assert set(errors_in(log, "ring")) <= {"absent", reason}
