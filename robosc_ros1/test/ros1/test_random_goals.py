"""Goals that are replaced and cancelled at random: whoever follows them knows when they run."""

from __future__ import annotations

import contextlib
import os
from collections.abc import Iterator
from pathlib import Path
from typing import Any

from random_goals import GUARDED, at_rest, check, check_monitor
from ros1.stage import Node, Puppet, Stage
from ros_support import PYTHON, await_condition

from robosc.runtime.settings import Settings

GOALS = int(os.environ.get("ROBOSC_GOALS", "300"))
REMAP = [f"/{name}:=/supervised/{name}" for name in GUARDED]


@contextlib.contextmanager
def follower(
    stage: Stage, ear: Puppet, folder: Path, mode: str, **more: Any
) -> Iterator[tuple[Node, Path]]:
    """A package of the courier, and its event log."""
    log = folder / f"{mode}.jsonl"
    more = {"event_log": log, "event_log_size": 1000.0, **more}
    with stage.controller(ear, f"courier_{mode}", **more) as node:
        yield node, log


@contextlib.contextmanager
def server(stage: Stage, folder: Path, listeners: int = 1) -> Iterator[Path]:
    """The robot of random goals, with so many nodes that listen to it; what it tells of them."""
    told = folder / "goals.txt"
    node = str(Path(__file__).with_name("random_goals_node.py"))
    with stage.workspace.start(
        str(PYTHON), node, "7", str(GOALS), str(told), str(listeners), master=stage.master
    ) as process:
        yield told
        log: Path = process.log  # type: ignore[attr-defined]
        await_condition(lambda: "enough" in log.read_text(), "all goals", 60.0 + GOALS / 5)


def test_goals_that_are_replaced_and_cancelled_at_random(
    stage: Stage, ear: Puppet, tmp_path: Path
) -> None:
    with follower(stage, ear, tmp_path, "controller", rate__go=100.0) as (controller, log):
        with server(stage, tmp_path) as told:
            pass
        controller.shows(at_rest, since=ear.mark)
    check(log, told, GOALS)


def test_a_supervisor_and_a_monitor_follow_them_too(
    stage: Stage, ear: Puppet, tmp_path: Path
) -> None:
    with (
        follower(stage, ear, tmp_path, "monitor") as (_, seen),
        follower(stage, ear, tmp_path, "supervisor") as (supervisor, guarded),
        follower(stage, ear, tmp_path, "controller", rate__go=100.0, remap=REMAP) as (
            controller,
            sent,
        ),
    ):
        with server(stage, tmp_path, listeners=2) as told:
            pass
        mark = ear.mark
        for node in (controller, supervisor):
            node.shows(at_rest, since=mark)
    check(sent, told, GOALS)
    check(guarded, told, GOALS)
    check_monitor(seen, told, Settings().tolerance)
