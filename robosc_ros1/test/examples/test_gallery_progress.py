"""What the gallery's bridge makes of what a controller says of itself."""

from __future__ import annotations

import json
from types import SimpleNamespace
from typing import Any

import pytest

from physics.progress import Progress

COMMUNICATIONS = [
    {"name": "line", "identifier": "/line"},
    {"name": "move", "identifier": "/cmd_vel"},
    {"name": "halt", "identifier": "/cmd_vel"},
    {"name": "drive", "identifier": "/drive"},
]


def said(document: dict[str, Any]) -> SimpleNamespace:
    return SimpleNamespace(data=json.dumps(document))


@pytest.fixture
def progress() -> Progress:
    made = Progress()
    assert not made.is_known
    made.on_model(said({"communications": COMMUNICATIONS}))
    assert made.is_known
    return made


def happens(progress: Progress, kind: str, name: str, outcome: str = "applied") -> None:
    progress.on_event(said({"event": {"kind": kind, "name": name}, "outcome": outcome}))


def test_messages_count_by_topic(progress: Progress) -> None:
    happens(progress, "response", "line")
    happens(progress, "response", "line", "mismatch")
    happens(progress, "request", "move")
    happens(progress, "request", "halt")
    happens(progress, "request", "halt", "failed")
    assert progress.taken == {"/line": 2}
    assert progress.under_way == {"/cmd_vel": 2}


def test_time_and_what_came_before_the_model_count_for_nothing(progress: Progress) -> None:
    happens(progress, "after", "Pause")
    happens(Progress(), "response", "line")
    assert not progress.taken and not progress.under_way


@pytest.mark.parametrize("end", ["response", "error"])
def test_goal_is_active_until_its_end_is_taken(progress: Progress, end: str) -> None:
    happens(progress, "request", "drive")
    assert progress.active == {"/drive"}
    progress.under_way["/drive"] -= 1  # it arrived
    happens(progress, end, "drive")
    assert not progress.active
    assert progress.taken["/drive"] == 1
    assert progress.under_way["/drive"] == 0


def test_goal_that_ended_before_it_arrived_is_not_under_way(progress: Progress) -> None:
    happens(progress, "request", "drive")
    happens(progress, "error", "drive")
    assert progress.under_way["/drive"] == 0


def test_goal_after_a_cancelled_one_is_not_cancelled(progress: Progress) -> None:
    happens(progress, "request", "drive")
    happens(progress, "cancel", "drive")
    assert progress.cancelled == {"/drive"} and not progress.active
    happens(progress, "request", "drive")
    assert not progress.cancelled and progress.active == {"/drive"}


def test_commands_of_the_guarded_count_by_topic_whether_passed_or_blocked(
    progress: Progress,
) -> None:
    happens(progress, "request", "move")
    progress.on_blocked(said({"event": {"kind": "request", "name": "move"}}))
    progress.on_blocked(said({"event": {"kind": "request", "name": "halt"}}))
    progress.on_blocked(said({"event": {"kind": "cancel", "name": "drive"}}))
    assert progress.judged["/cmd_vel"] == 3
    assert progress.judged["/drive"] == 0
