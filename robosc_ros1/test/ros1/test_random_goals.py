"""Goals that are replaced and cancelled at random: whoever follows them knows when they run."""

from __future__ import annotations

import contextlib
import os
import random
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest
from random_goals import GUARDED, at_rest, check, check_monitor, check_order, has_told
from ros1.stage import Node, Puppet, Stage
from ros_support import await_condition

NODE = str(Path(__file__).with_name("random_goals_node.py"))
GOALS = int(os.environ.get("ROBOSC_GOALS", "300"))
CROSSING = 0.5
"""Seconds by which messages may cross: a busy machine has let the thread of a topic wait for 0.2."""
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
    words = (NODE, "7", str(GOALS), str(told), str(listeners))
    with stage.workspace.fork(*words, master=stage.master) as process:
        yield told
        await_condition(lambda: "enough" in process.log.read_text(), "all goals", 60.0 + GOALS / 5)


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
        follower(stage, ear, tmp_path, "monitor", tolerance=CROSSING) as (_, seen),
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
    check_monitor(seen, told, CROSSING)


@pytest.mark.parametrize("modes", [("controller",), ("supervisor", "controller")])
def test_servers_that_are_killed_at_random(
    stage: Stage, ear: Puppet, tmp_path: Path, modes: tuple[str, ...]
) -> None:
    moments = random.Random(len(modes))
    settings = {"rate__go": 100.0, "server_lost_after": 1.0, "timeout__go": 2.0}
    with contextlib.ExitStack() as running:
        nodes, logs = [], []
        for mode in modes:
            remap = REMAP if mode == "controller" and len(modes) > 1 else []
            followed = follower(stage, ear, tmp_path, mode, remap=remap, **settings)
            node, log = running.enter_context(followed)
            nodes.append(node)
            logs.append(log)
        for number in range(6):
            told = tmp_path / f"goals_{number}.txt"
            words = (NODE, str(number), "100000", str(told), "1")
            with stage.workspace.fork(*words, master=stage.master) as victim:
                count = moments.randint(3, 60)
                await_condition(lambda t=told, c=count: has_told(t, c), f"goals of server {number}")
                victim.kill()
        with server(stage, tmp_path):
            pass
        for node in nodes:
            node.shows(at_rest, since=ear.mark)
    for log in logs:
        check_order(log)
