"""Each reason of an error is reached by a real cause on ROS 1."""

from __future__ import annotations

import os
import signal
from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any

import pytest
from ros1.stage import Node, Puppet, Stage, event

GO = {"name": "/go", "type": "robot_common/NavigateAction"}


@contextmanager
def courier(stage: Stage, ear: Puppet, puppet: Puppet, **given: Any) -> Iterator[Node]:
    """A courier that is wanted to go somewhere."""
    with stage.controller(ear, "courier_controller", **given) as node:
        puppet.publish("/wanted", "std_msgs/Bool", True)
        yield node


@pytest.mark.parametrize(
    ("reason", "served", "given"),
    [
        ("absent", None, {"timeout__go": 0.5}),
        ("rejected", {"mode": "reject"}, {}),
        ("failed", {"mode": "abort"}, {}),
        ("failed", {"mode": "preempt"}, {}),
        ("refused", {"mode": "succeed", "fields": {"distance": 9.0}}, {}),
        ("timeout", {"mode": "hold"}, {"goal_timeout__go": 0.5}),
        ("timeout", {"mode": "ignore"}, {"timeout__go": 0.5, "server_lost_after": 0.5}),
    ],
)
def test_the_reason_of_an_error(
    stage: Stage,
    puppet: Puppet,
    ear: Puppet,
    reason: str,
    served: dict[str, Any] | None,
    given: dict[str, Any],
) -> None:
    if served is not None:
        puppet.do("action", **GO, **served)
    with courier(stage, ear, puppet, **given) as node:
        assert node.tells(event("error", "go"))["reason"] == reason


@pytest.mark.once
def test_a_server_that_vanished_is_lost(stage: Stage, puppet: Puppet, ear: Puppet) -> None:
    with stage.puppet() as victim:
        victim.do("action", **GO, mode="hold")
        with courier(stage, ear, puppet, server_lost_after=1.0) as node:
            victim.wait(lambda line: line.get("asked") == "/go", "the goal")
            node.shows(lambda s: s["communications"]["go"] == "busy")
            os.kill(victim.process.pid, signal.SIGKILL)
            assert node.tells(event("error", "go"))["reason"] == "lost"


@pytest.mark.parametrize(
    ("reason", "end"),
    [("failed", "abort"), ("refused", "succeed"), ("lost", None)],
)
def test_the_reason_of_an_error_while_cancelling(
    stage: Stage, puppet: Puppet, ear: Puppet, reason: str, end: str | None
) -> None:
    with stage.puppet() as victim:
        victim.do("action", **GO, mode="go on")
        with courier(stage, ear, puppet) as node:
            victim.wait(lambda line: line.get("asked") == "/go", "the goal")
            puppet.publish("/wanted", "std_msgs/Bool", False)
            victim.wait(lambda line: line.get("cancelled") == "/go", "the cancel")
            if end is None:
                os.kill(victim.process.pid, signal.SIGKILL)
            else:
                victim.do("finish", name="/go", mode=end, fields={"distance": 9.0})
            told = node.tells(event("error", "go"))
            assert (told["reason"], told["outcome"]) == (reason, "applied")
            assert len(node.events(event("cancel", "go"))) == 1


@pytest.mark.parametrize(
    ("reason", "served"),
    [
        ("absent", None),
        ("failed", {"mode": "throw"}),
        ("failed", {"mode": "fail"}),
        ("refused", {"mode": "answer", "fields": {"success": False}}),
        ("timeout", {"mode": "hang"}),
    ],
)
def test_the_reason_of_an_error_of_a_service(
    stage: Stage, puppet: Puppet, ear: Puppet, reason: str, served: dict[str, Any] | None
) -> None:
    if served is not None:
        puppet.do("service", name="/ring", type="std_srvs/Trigger", **served)
    with stage.controller(ear, "bell_controller") as node:
        assert node.tells(event("error", "ring"))["reason"] == reason
