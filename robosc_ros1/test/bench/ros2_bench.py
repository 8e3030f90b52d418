"""A message that passes a ROS 2 supervisor beside one through a bare relay, on real rclpy.

``./dev bench ros2``. Needs the wheels that the tests of ROS 2 use, and generates the supervisor of
``ros2/models/guarded_arm.rscd`` first.
"""

from __future__ import annotations

import argparse
import json
import tempfile
from pathlib import Path

from bench.ros_bench import report_guard
from ros2.ros2_support import Graph, Unavailable, free_domain, test_bed

from robosc import pipeline

__all__ = ["main"]

HERE = Path(__file__).resolve().parent
MODEL = HERE.parent / "ros2" / "models" / "guarded_arm.rscd"


def main(arguments: list[str] | None = None) -> int:
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("--samples", type=int, default=3000)
    args = parser.parse_args(arguments)
    try:
        bed = test_bed()
    except Unavailable as reason:
        print(f"ros2: skipped: {reason}")
        return 0
    with tempfile.TemporaryDirectory(prefix="robosc-bench-") as name, free_domain() as domain:
        folder = Path(name)
        output = pipeline.Output(target="ros2", mode="supervisor", folder=folder)
        pipeline.generate(MODEL, output=output)
        found = folder / "guard.json"
        graph = Graph(bed, domain, folder)
        try:
            node = "from guarded_arm_supervisor.node import main; main()"
            path = f"{folder / 'guarded_arm_supervisor'}:{bed.environment['PYTHONPATH']}"
            graph.start(bed.python, "-c", node, PYTHONPATH=path)
            graph.start(bed.python, HERE / "relay_node_ros2.py")
            probe = graph.start(bed.python, HERE / "guard_node_ros2.py", args.samples, found)
            assert probe.wait(args.samples * 0.1 + 60) == 0, probe.output
        finally:
            graph.close()
        return report_guard(json.loads(found.read_text(encoding="utf-8")))


if __name__ == "__main__":
    raise SystemExit(main())
