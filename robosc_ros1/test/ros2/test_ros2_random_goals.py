"""Goals that are replaced and cancelled at random: whoever follows them knows when they run."""

from __future__ import annotations

import os
import random
import signal
from collections.abc import Callable
from pathlib import Path

import pytest
from random_goals import GUARDED, at_rest, check, check_monitor, check_order, has_told
from ros2.bed import HERE
from ros2.ros2_support import Graph, Process
from ros_support import await_condition

NODE = HERE / "random_goals_node.py"
GOALS = int(os.environ.get("ROBOSC_GOALS", "300"))
PARTS = ("send_goal", "cancel_goal", "get_result", "feedback", "status")
REMAP = [f"/{name}:=/supervised/{name}" for name in GUARDED]
REMAP += [f"/go/_action/{part}:=/supervised/go/_action/{part}" for part in PARTS]


def follow(
    graph: Graph, controller: Callable[..., Process], modes: dict[str, list[str]], folder: Path
) -> tuple[list[Path], Path]:
    """Have random goals carried out, and followed by packages of the courier, by their rules of
    remapping; return their event logs, and what the server tells."""
    told, logs = folder / "goals.txt", []
    for mode, remap in modes.items():
        logs.append(folder / f"{mode}.jsonl")
        qos = {f"qos__{name}__reliability": "reliable" for name in ("place", "wanted")}
        more = {"event_log": str(logs[-1]), "event_log_size": 1000.0}
        more |= {"rate__go": 100.0} if mode == "controller" else {}
        controller(f"courier_{mode}", remap, **qos, **more)
    listeners = str(min(2, len(modes)))
    server = graph.fork(NODE, "7", str(GOALS), told, listeners)
    await_condition(lambda: "enough" in server.output, "all goals", 60.0 + GOALS / 5)
    robot = graph.peer()
    for name in (f"courier_{mode}" for mode in modes if mode != "monitor"):
        robot.watch(name)  # now, or a state of the beginning would pass for the end
        robot.expect_state(name, at_rest)
    return logs, told


def test_goals_that_are_replaced_and_cancelled_at_random(
    graph: Graph, controller: Callable[..., Process], tmp_path: Path
) -> None:
    (log,), told = follow(graph, controller, {"controller": []}, tmp_path)
    check(log, told, GOALS)


def test_a_supervisor_and_a_monitor_follow_them_too(
    graph: Graph, controller: Callable[..., Process], tmp_path: Path
) -> None:
    modes = {"monitor": [], "supervisor": [], "controller": REMAP}
    logs, told = follow(graph, controller, modes, tmp_path)
    seen, *others = logs
    for log in others:
        check(log, told, GOALS)
    check_monitor(seen, told, None)  # a goal that is rejected cannot be heard


@pytest.mark.parametrize("modes", [("controller",), ("supervisor", "controller")])
def test_servers_that_are_killed_at_random(
    graph: Graph, controller: Callable[..., Process], tmp_path: Path, modes: tuple[str, ...]
) -> None:
    moments = random.Random(len(modes))
    settings = {f"qos__{name}__reliability": "reliable" for name in ("place", "wanted")}
    settings |= {"rate__go": 100.0, "server_lost_after": 1.0, "timeout__go": 2.0}
    logs = [tmp_path / f"{mode}.jsonl" for mode in modes]
    for mode, log in zip(modes, logs, strict=True):
        remap = REMAP if mode == "controller" and len(modes) > 1 else []
        settings |= {"event_log": str(log), "event_log_size": 1000.0}
        controller(f"courier_{mode}", remap, **settings)
    # How soon a killed process is noticed, is said by itself when it joins.
    profile = str(HERE / "short_lease.xml")
    for number in range(6):
        told = tmp_path / f"goals_{number}.txt"
        words = (NODE, str(number), "100000", told, "1")
        victim = graph.fork(*words, FASTRTPS_DEFAULT_PROFILES_FILE=profile)
        count = moments.randint(3, 60)
        await_condition(lambda t=told, c=count: has_told(t, c), f"goals of server {number}")
        victim.signal(signal.SIGKILL)
    last = graph.fork(NODE, "7", "30", tmp_path / "goals.txt", "1")
    await_condition(lambda: "enough" in last.output, "the goals of the last server")
    robot = graph.peer()
    for mode, log in zip(modes, logs, strict=True):
        robot.watch(f"courier_{mode}")
        robot.expect_state(f"courier_{mode}", at_rest)
        check_order(log)
