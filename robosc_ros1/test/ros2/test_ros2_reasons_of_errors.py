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


def errors_in(log: Path) -> list[str]:
    """The reasons of the errors in an event log."""
    lines = log.read_text().splitlines() if log.is_file() else []
    found = [json.loads(line) for line in lines]
    return [
        e["reason"] for e in found if (e["event"]["kind"], e["event"]["name"]) == ("error", "go")
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
    ],
)
def test_the_reason_of_an_error(
    courier: Callable[..., tuple[Peer, Path]],
    reason: str,
    policy: dict[str, Any] | None,
    given: dict[str, Any],
) -> None:
    robot, log = courier(policy, **given)
    if reason == "timeout":
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
