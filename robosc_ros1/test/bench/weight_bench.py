"""How long an emergency stop takes beside a topic with messages of ten megabytes.

``./dev bench weight -- --ros 1 --samples 300``. A bare subscriber with a queue of one gets the same
messages in the same run. Needs ROS 1, or the wheels that the tests of ROS 2 use.
"""

from __future__ import annotations

import argparse
import contextlib
import json
import subprocess
import tempfile
import time
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import ros_support
from bench.ros2_bench import ended, generated
from bench.ros_bench import quantiles, resident
from ros2.bed import Unavailable, test_bed
from ros2.ros2_support import Graph, free_domain
from ros_support import PYTHON, Workspace

from robosc import pipeline

__all__ = ["main"]

HERE = Path(__file__).resolve().parent
HEAVY = HERE / "heavy.rscd"
LIMIT = 2.0
"""So many times as long as the bare subscriber may the node take for 99 of 100 messages."""
MEMORY = 200_000
"""kB that the node may take."""


def main(arguments: list[str] | None = None) -> int:
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("--ros", type=int, choices=(1, 2), nargs="*", default=(1, 2))
    parser.add_argument(
        "--mode", default="controller", choices=("controller", "supervisor", "monitor")
    )
    parser.add_argument("--samples", type=int, default=300)
    parser.add_argument("--megabytes", type=float, default=10.0)
    parser.add_argument("--rate", type=float, default=5.0, help="heavy messages per second")
    args = parser.parse_args(arguments)
    failed = 0
    for version in args.ros:
        with tempfile.TemporaryDirectory(prefix="robosc-bench-") as folder:
            found = {1: run_ros1, 2: run_ros2}[version](Path(folder), args)
        if found is not None:
            failed |= report(f"ROS {version}", *found)
    return failed


Found = tuple[dict[str, Any], int]
"""The latencies of both, and the greatest memory of the node in kB."""


def run_ros1(folder: Path, args: argparse.Namespace) -> Found | None:
    reason = ros_support.missing_ros()
    if reason is not None:
        print(f"ROS 1: skipped: {reason}")
        return None
    workspace = Workspace(folder / "ws")
    output = pipeline.Output(target="ros1", mode=args.mode, folder=workspace.folder / "src")
    package = pipeline.generate(HEAVY, output=output).files.folder.name
    workspace.build()
    (folder / "master").mkdir()
    part = (str(PYTHON), str(HERE / "weight_node.py"))
    file = folder / "found.json"
    with (
        ros_support.master(folder / "master") as master,
        workspace.start("rosrun", package, package, master=master) as node,
        workspace.start(*part, "bare", master=master),
        workspace.start(*part, "heavy", str(args.megabytes), str(args.rate), master=master),
    ):
        probe = [*part, "probe", str(args.samples), str(file)]
        process = subprocess.Popen(probe, env=workspace.environment(master=master))
        memory = watched(process, node.pid)
    return json.loads(file.read_text(encoding="utf-8")), memory


def run_ros2(folder: Path, args: argparse.Namespace) -> Found | None:
    try:
        bed = test_bed()
    except Unavailable as reason:
        print(f"ROS 2: skipped: {reason}")
        return None
    file = folder / "found.json"
    with free_domain() as domain:
        graph = Graph(bed, domain, folder)
        with ended(graph):
            node = generated(graph, HEAVY, args.mode)
            part = (bed.python, HERE / "weight_node_ros2.py")
            graph.start(*part, "bare")
            graph.start(*part, "heavy", str(args.megabytes), str(args.rate))
            probe = graph.start(*part, "probe", str(args.samples), file)
            memory = watched(probe.popen, node.popen.pid)
            assert probe.wait(1.0) == 0, probe.output
    return json.loads(file.read_text(encoding="utf-8")), memory


def watched(process: subprocess.Popen[bytes], node: int) -> int:
    """Wait until a process has ended; the greatest memory of a node meanwhile, in kB."""
    memory = 0
    for size in _sizes(process, node):
        memory = max(memory, size)
    return memory


def _sizes(process: subprocess.Popen[bytes], node: int) -> Iterator[int]:
    while process.poll() is None:
        with contextlib.suppress(OSError):
            yield resident(node)
        time.sleep(0.1)


def report(title: str, latencies: dict[str, Any], memory: int) -> int:
    """Print what was found; 1 if a limit is exceeded."""
    times = {name: quantiles(samples) for name, samples in latencies.items()}
    lost = {name: sum(s is None for s in samples) for name, samples in latencies.items()}
    print(
        f"{title}: an emergency stop beside heavy messages, {len(latencies['node'])} times, in ms"
    )
    for name in times["node"]:
        bare, node = times["bare"][name] / 1e3, times["node"][name] / 1e3
        print(f"  {name:9} bare {bare:9.1f}   node {node:9.1f}   ratio {node / bare:6.2f}")
    print(f"  unanswered: bare {lost['bare']}, node {lost['node']}; memory at most {memory} kB")
    slow = times["node"]["99 %"] > LIMIT * times["bare"]["99 %"]
    return int(slow or lost["node"] > 0 or memory > MEMORY)


if __name__ == "__main__":
    raise SystemExit(main())
