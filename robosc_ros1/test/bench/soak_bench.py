"""Generated nodes of all four kinds for a long time beside bare relays: time, memory, files.

``./dev bench soak``, ``-- --seconds 1200`` for a long one. Controllers and supervisors of
``soak.rscd`` run on ROS 1 and ROS 2 at once, each with 20 scans of 360 numbers per second. Needs
both ROS.
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
from bench.ros_bench import quantiles, resident
from ros2.bed import Unavailable, test_bed
from ros2.ros2_support import Graph, free_domain
from ros_support import PYTHON, plain_environment

from robosc import pipeline

__all__ = ["main"]

HERE = Path(__file__).resolve().parent
MODEL = HERE / "soak.rscd"
MODES: tuple[pipeline.Mode, ...] = ("controller", "supervisor")
LIMIT = 1.6
"""So many times as long as a relay may a node take with telemetry and scans."""
GROWTH = 1.05
"""So much may the memory of a node grow from the middle to the end."""


def main(arguments: list[str] | None = None) -> int:
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("--seconds", type=float, default=60.0)
    parser.add_argument("--quiet", action="store_true", help="nobody listens to what nodes show")
    args = parser.parse_args(arguments)
    try:
        bed = test_bed()
    except Unavailable as reason:
        print(f"soak: skipped: {reason}")
        return 0
    missing = ros_support.missing_ros()
    if missing is not None:
        print(f"soak: skipped: {missing}")
        return 0
    with contextlib.ExitStack() as stack:
        folder = Path(stack.enter_context(tempfile.TemporaryDirectory(prefix="robosc-soak-")))
        (folder / "log").mkdir()
        master = stack.enter_context(ros_support.master(folder / "log"))
        graph = Graph(bed, stack.enter_context(free_domain()), folder)
        stack.callback(graph.close)
        listen = "alone" if args.quiet else "listen"
        words = (str(args.seconds), listen)
        nodes: dict[str, int] = {}
        env = plain_environment(**master.environment, ROS_LOG_DIR=str(folder / "log"))
        for mode in MODES:
            package = generated(folder / "ros1", "ros1", mode)
            code = f"from {package.name}.start import main; main()"
            own = env | {"PYTHONPATH": str(package / "src"), "ROS_NAMESPACE": f"/{mode}"}
            command = [str(PYTHON), "-c", code]
            nodes[f"{mode} of ROS 1"] = stack.enter_context(running(command, own, folder, mode))
            package = generated(folder / "ros2", "ros2", mode)
            code = f"from {package.name}.start import main; main()"
            path = f"{package}:{bed.environment['PYTHONPATH']}"
            space = ("--ros-args", "-r", f"__ns:=/{mode}")
            process = graph.start(bed.python, "-c", code, *space, PYTHONPATH=path)
            nodes[f"{mode} of ROS 2"] = process.popen.pid
        relay = [str(PYTHON), str(HERE / "relay_node.py")]
        stack.enter_context(running(relay, env, folder, "relay"))
        graph.start(bed.python, HERE / "relay_node_ros2.py")
        found = [folder / f"latency{version}.json" for version in (1, 2)]
        probe = [str(PYTHON), str(HERE / "soak_node.py"), "1", *words, str(found[0])]
        stack.enter_context(running(probe, env, folder, "probe"))
        graph.start(bed.python, HERE / "soak_node.py", "2", *words, found[1])
        memory: dict[str, list[int]] = {name: [] for name in nodes}
        held: dict[str, list[tuple[int, ...]]] = {name: [] for name in nodes}
        end = time.monotonic() + 2 * args.seconds + 120
        while not all(file.exists() for file in found):
            assert time.monotonic() < end, "the nodes that measure did not end"
            for name, pid in nodes.items():
                memory[name].append(resident(pid))
                process = Path(f"/proc/{pid}")
                held[name].append(
                    tuple(sum(1 for _ in (process / kind).iterdir()) for kind in ("task", "fd"))
                )
            time.sleep(1.0)
        time.sleep(1.0)
        taken = [json.loads(file.read_text(encoding="utf-8")) for file in found]
    return report(taken, memory, held)


def generated(folder: Path, target: pipeline.Target, mode: pipeline.Mode) -> Path:
    output = pipeline.Output(target=target, mode=mode, folder=folder)
    return pipeline.generate(MODEL, output=output).files.folder


@contextlib.contextmanager
def running(command: list[str], env: dict[str, str], folder: Path, name: str) -> Iterator[int]:
    """A process of ROS 1, by its id."""
    with (folder / f"{name}.log").open("wb") as log:
        process = subprocess.Popen(command, env=env, stdout=log, stderr=log)
        try:
            yield process.pid
        finally:
            process.terminate()
            with contextlib.suppress(subprocess.TimeoutExpired):
                process.wait(5)
            process.kill()


def report(
    taken: list[dict[str, Any]],
    memory: dict[str, list[int]],
    held: dict[str, list[tuple[int, ...]]],
) -> int:
    """Print what was measured; 1 if a limit is exceeded."""
    failed = False
    for version, found in enumerate(taken, 1):
        times = found["latencies"]
        print(f"ROS {version}: {len(times['relay'])} messages each, in microseconds")
        for mode in MODES:
            # A supervisor passes bytes on, and so does the relay beside it, where it can.
            beside = "relay of bytes" if (version, mode) == (2, "supervisor") else "relay"
            relay = quantiles(times[beside])
            print(f"  {beside:20} {told(relay, relay)}")
            name = f"{mode} of ROS {version}"
            lost = sum(sample is None for sample in times[mode])
            own = quantiles(times[mode])
            space = memory[name]
            start, middle, end = (space[int(f * (len(space) - 1))] for f in (0.1, 0.5, 1.0))
            print(f"  {name:20} {told(own, relay)}  lost {lost}")
            print(f"  {'':20} memory {start} kB, {middle} kB, {end} kB")
            half = len(held[name]) // 2
            first, second = (
                tuple(map(max, zip(*part, strict=True)))
                for part in (held[name][:half], held[name][half:])
            )
            print(f"  {'':20} at most {first[0]} threads, {first[1]} files; then {second}")
            failed |= lost > 0 or end > GROWTH * middle
            failed |= any(later > before for before, later in zip(first, second, strict=True))
            failed |= any(own[q] > LIMIT * relay[q] for q in ("median", "99 %"))
        print(f"  documents heard: {found['shown']}")
    return int(failed)


def told(own: dict[str, float], relay: dict[str, float]) -> str:
    return "  ".join(f"{name} {own[name]:6.0f} ({own[name] / relay[name]:4.2f})" for name in own)


if __name__ == "__main__":
    raise SystemExit(main())
