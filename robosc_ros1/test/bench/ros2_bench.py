"""Generated nodes on real rclpy: a message that passes a supervisor beside one through a bare relay,
and a flood of messages for a controller.

``./dev bench ros2``. Needs the wheels that the tests of ROS 2 use, and generates the packages of
``ros2/models/guarded_arm.rscd`` first.
"""

from __future__ import annotations

import argparse
import json
import tempfile
import time
from pathlib import Path
from typing import Any

from bench.ros_bench import report_flood, report_guard, resident
from ros2.ros2_support import Graph, Process, Unavailable, free_domain, test_bed

from robosc import pipeline

__all__ = ["main"]

HERE = Path(__file__).resolve().parent
MODEL = HERE.parent / "ros2" / "models" / "guarded_arm.rscd"


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
        try:
            guarded = run_guard(graph, args.samples)
        finally:
            graph.close()
        try:
            flood, memory = run_flood(graph, args.seconds, args.rate)
        finally:
            graph.close()
    return report_guard(guarded) | report_flood(flood, memory)


def generated(graph: Graph, mode: pipeline.Mode, *arguments: str) -> Process:
    """The node of the model's package, generated and started."""
    output = pipeline.Output(target="ros2", mode=mode, folder=graph.folder)
    package = pipeline.generate(MODEL, output=output).files.folder
    code = f"from {package.name}.node import main; main()"
    path = f"{package}:{graph.bed.environment['PYTHONPATH']}"
    return graph.start(graph.bed.python, "-c", code, *arguments, PYTHONPATH=path)


def run_guard(graph: Graph, samples: int) -> dict[str, Any]:
    """What guard_node_ros2.py found."""
    found = graph.folder / "guard.json"
    generated(graph, "supervisor")
    graph.start(graph.bed.python, HERE / "relay_node_ros2.py")
    probe = graph.start(graph.bed.python, HERE / "guard_node_ros2.py", str(samples), found)
    assert probe.wait(samples * 0.1 + 60) == 0, probe.output
    guarded: dict[str, Any] = json.loads(found.read_text(encoding="utf-8"))
    return guarded


def run_flood(graph: Graph, seconds: float, rate: float) -> tuple[dict[str, Any], list[int]]:
    """What flood_node_ros2.py found, and the controller's memory in kB, once per second."""
    found = graph.folder / "flood.json"
    words = ["--ros-args", "-p", "rate:=0.1"]
    for name in ("zone", "charge"):
        words += ["-p", f"qos.{name}.reliability:=reliable", "-p", f"qos.{name}.depth:=1000"]
    controller = generated(graph, "controller", *words)
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
