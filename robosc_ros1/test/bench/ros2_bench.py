"""Generated nodes on real rclpy: latency of a controller and of a supervisor beside bare relays, and
a flood of messages for a controller.

``./dev bench ros2``. Needs the wheels that the tests of ROS 2 use, and generates the packages of
``horn.rscd`` and ``ros2/models/guarded_arm.rscd`` first.
"""

from __future__ import annotations

import argparse
import contextlib
import json
import tempfile
import time
from collections.abc import Iterator
from pathlib import Path
from typing import Any

from bench.ros_bench import report_flood, report_latency, resident
from ros2.bed import Unavailable, test_bed
from ros2.ros2_support import Graph, Process, free_domain

from robosc import pipeline

__all__ = ["main"]

HERE = Path(__file__).resolve().parent
ARM = HERE.parent / "ros2" / "models" / "guarded_arm.rscd"
HORN = HERE / "horn.rscd"
LIMITER = HERE / "limiter.rscd"
SLOW = ("--ros-args", "-p", "rate:=0.001")
"""So that repetitions do not come between."""


def main(arguments: list[str] | None = None) -> int:
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("--samples", type=int, default=3000)
    parser.add_argument("--seconds", type=float, default=60.0, help="length of the flood")
    parser.add_argument("--rate", type=float, default=2000.0, help="messages per second of it")
    args = parser.parse_args(arguments)
    try:
        bed = test_bed()
    except Unavailable as reason:
        print(f"ros2: skipped: {reason}")
        return 0
    with tempfile.TemporaryDirectory(prefix="robosc-bench-") as name, free_domain() as domain:
        folder = Path(name)
        graph = Graph(bed, domain, folder)
        with ended(graph):
            controlled = run_latency(graph, HORN, "controller", args.samples, *SLOW)
        with ended(graph):
            guarded = run_latency(graph, ARM, "supervisor", args.samples)
        with ended(graph):
            limited = run_latency(graph, LIMITER, "limiter", args.samples)
        with ended(graph):
            flood, memory = run_flood(graph, args.seconds, args.rate)
    failed = report_latency(controlled, "controller") | report_latency(guarded, "supervisor")
    failed |= report_latency(limited, "limiter")
    return failed | report_flood(flood, memory)


@contextlib.contextmanager
def ended(graph: Graph) -> Iterator[None]:
    """All that is started within is ended at the end."""
    try:
        yield
    finally:
        graph.close()


def generated(graph: Graph, model: Path, mode: pipeline.Mode, *arguments: str) -> Process:
    """The node of a model's package, generated and started."""
    output = pipeline.Output(target="ros2", mode=mode, folder=graph.folder)
    package = pipeline.generate(model, output=output).files.folder
    code = f"from {package.name}.start import main; main()"
    path = f"{package}:{graph.bed.environment['PYTHONPATH']}"
    return graph.start(graph.bed.python, "-c", code, *arguments, PYTHONPATH=path)


def run_latency(
    graph: Graph, model: Path, node: str, samples: int, *arguments: str
) -> dict[str, Any]:
    """What latency_node_ros2.py found."""
    found = graph.folder / "latency.json"
    generated(graph, model, "controller" if node == "controller" else "supervisor", *arguments)
    graph.start(graph.bed.python, HERE / "relay_node_ros2.py")
    probe = graph.start(graph.bed.python, HERE / "latency_node_ros2.py", node, str(samples), found)
    assert probe.wait(samples * 0.1 + 60) == 0, probe.output
    taken: dict[str, Any] = json.loads(found.read_text(encoding="utf-8"))
    return taken


def run_flood(graph: Graph, seconds: float, rate: float) -> tuple[dict[str, Any], list[int]]:
    """What flood_node_ros2.py found, and the controller's memory in kB, once per second."""
    found = graph.folder / "flood.json"
    words = ["--ros-args", "-p", "rate:=0.1"]
    for name in ("zone", "charge"):
        words += ["-p", f"qos.{name}.reliability:=reliable", "-p", f"qos.{name}.depth:=1000"]
    controller = generated(graph, ARM, "controller", *words)
    arguments = (str(seconds), str(rate), found)
    probe = graph.start(graph.bed.python, HERE / "flood_node_ros2.py", *arguments)
    memory = []
    while probe.popen.poll() is None and len(memory) < seconds + 120:
        memory.append(resident(controller.popen.pid))
        time.sleep(1.0)
    assert probe.wait(1.0) == 0, probe.output
    flood: dict[str, Any] = json.loads(found.read_text(encoding="utf-8"))
    return flood, memory


if __name__ == "__main__":
    raise SystemExit(main())
