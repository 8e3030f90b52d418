"""Generated nodes on a real roscore: latency beside a bare relay, and a flood of messages.

``PYTHONPATH=robosc_ros1/src:robosc_ros1/test python3 robosc_ros1/test/bench/ros_bench.py``, or
``./dev bench ros``. Needs ROS 1; builds the package of ``golden/models/probe.rscd`` first.
"""

from __future__ import annotations

import argparse
import json
import subprocess
import tempfile
import time
from pathlib import Path
from typing import Any

import ros_support
from emit.golden_packages import GOLDEN, model_path, package_of
from ros_support import PYTHON, Master, Workspace

from robosc import pipeline
from robosc.emit.package import ros1_target
from robosc.emit.write.writer import write

__all__ = ["main"]

HERE = Path(__file__).resolve().parent
LIMITER = ros_support.EXAMPLES / "gallery" / "limiter" / "limiter.rscd"
LIMITS = {"controller": 1.3, "supervisor": 1.5, "limiter": 1.3}
"""So many times as long as a relay may a node take on an idle machine, but for one message in 100."""


def main(arguments: list[str] | None = None) -> int:
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("--samples", type=int, default=3000)
    parser.add_argument("--seconds", type=float, default=60.0, help="length of the flood")
    parser.add_argument("--rate", type=float, default=2000.0, help="messages per second of it")
    args = parser.parse_args(arguments)
    reason = ros_support.missing_ros()
    if reason is not None:
        print(f"ros: skipped: {reason}")
        return 0
    with tempfile.TemporaryDirectory(prefix="robosc-bench-") as folder:
        workspace = built_workspace(Path(folder) / "ws")
        (Path(folder) / "master").mkdir()
        with ros_support.master(Path(folder) / "master") as master:
            result, memory = run(workspace, master, args)
            guarded = run_guard(workspace, master, "supervisor", args.samples)
            limited = run_guard(workspace, master, "limiter", args.samples)
    failed = report(result, memory) | report_latency(guarded, "supervisor")
    return failed | report_latency(limited, "limiter")


def built_workspace(folder: Path) -> Workspace:
    workspace = Workspace(folder)
    workspace.add(GOLDEN / "models" / "gauntlet_interfaces")
    write(package_of("probe"), folder / "src")
    supervisor = pipeline.synthesize(pipeline.load(model_path("probe")).robot)
    write(ros1_target.emit(supervisor, "probe_supervisor", mode="supervisor"), folder / "src")
    output = pipeline.Output(target="ros1", mode="supervisor", folder=folder / "src")
    pipeline.generate(LIMITER, output=output)
    workspace.build()
    return workspace


def run(
    workspace: Workspace, master: Master, args: argparse.Namespace
) -> tuple[dict[str, Any], list[int]]:
    """What latency_node.py found, and the controller's memory in kB, once per second."""
    # The slowest rate, so that repetitions do not come between.
    node = ("rosrun", "probe_controller", "probe_controller", "_rate:=0.001")
    relay = (str(PYTHON), str(HERE / "relay_node.py"))
    probe = [str(PYTHON), str(HERE / "latency_node.py")]
    output = workspace.folder / "latency.json"
    probe += [str(args.samples), str(args.seconds), str(args.rate), str(output)]
    with (
        workspace.start(*node, master=master) as controller,
        workspace.start(*relay, master=master),
    ):
        process = subprocess.Popen(probe, env=workspace.environment(master=master))
        memory = []
        while process.poll() is None:
            memory.append(resident(controller.pid))
            time.sleep(1.0)
            if len(memory) > args.seconds + args.samples / 50 + 120:
                process.kill()
        return json.loads(output.read_text(encoding="utf-8")), memory


def run_guard(workspace: Workspace, master: Master, guard: str, samples: int) -> dict[str, Any]:
    """What guard_node.py found."""
    package = {"supervisor": "probe_supervisor", "limiter": "limiter_supervisor"}[guard]
    node = ("rosrun", package, package)
    relay = (str(PYTHON), str(HERE / "relay_node.py"))
    output = workspace.folder / "guard.json"
    probe = (str(PYTHON), str(HERE / "guard_node.py"), guard, str(samples), str(output))
    with workspace.start(*node, master=master), workspace.start(*relay, master=master):
        workspace.run(*probe, master=master)
    found: dict[str, Any] = json.loads(output.read_text(encoding="utf-8"))
    return found


def resident(pid: int) -> int:
    """Resident memory of a process in kB."""
    for line in Path(f"/proc/{pid}/status").read_text(encoding="utf-8").splitlines():
        if line.startswith("VmRSS:"):
            return int(line.split()[1])
    return 0


def quantiles(samples: list[float | None]) -> dict[str, float]:
    """Median, 99th percentile and greatest, in microseconds."""
    found = sorted(s for s in samples if s is not None)
    return {
        "median": found[len(found) // 2] * 1e6,
        "99 %": found[int(len(found) * 0.99)] * 1e6,
        "greatest": found[-1] * 1e6,
    }


def report(result: dict[str, Any], memory: list[int]) -> int:
    """Print what latency_node.py found; 1 if a limit is exceeded."""
    failed = report_latency(result["latencies"], "controller")
    if "flood" in result:
        failed |= report_flood(result["flood"], memory)
    return failed


def report_latency(taken: dict[str, Any], node: str) -> int:
    """Print how long a node takes beside the bare relay; 1 if a limit is exceeded."""
    times = {name: quantiles(samples) for name, samples in taken.items()}
    failed = False
    print(f"latency of {len(taken[node])} messages each, in microseconds")
    for name in times[node]:
        relay, own = times["relay"][name], times[node][name]
        verdict = ""
        if name != "greatest":
            verdict = f"  (at most {LIMITS[node]:g})"
            failed |= own > LIMITS[node] * relay
        print(
            f"  {name:9} relay {relay:8.0f}   {node} {own:8.0f}   ratio {own / relay:5.2f}{verdict}"
        )
    lost = sum(s is None for s in taken[node])
    print(f"  unanswered: {lost}")
    return int(failed or lost > 0)


def report_flood(flood: dict[str, Any], memory: list[int]) -> int:
    """Print what became of it, with the memory that was taken meanwhile.

    1 if a message was lost, or memory or the queue grew.
    """
    answers = quantiles(flood["answers"])
    print(f"flood: {flood['sent']} messages in {flood['seconds']:.1f} s")
    print(f"  received {flood['received']}, lost {flood['sent'] - flood['received']}")
    print(f"  command after: median {answers['median']:.0f} us, 99 % {answers['99 %']:.0f} us")
    late = memory[len(memory) // 3 :]
    print(f"  memory {late[0]} kB, at the end {late[-1]} kB")
    grown = late[-1] > 1.1 * late[0]
    waiting = flood.get("backlogs")
    if waiting:
        print(f"  inputs waiting: at most {max(waiting)}, at the end {waiting[-1]}")
        grown |= waiting[-1] > flood["sent"] / 100
    return int(flood["sent"] != flood["received"] or grown)


if __name__ == "__main__":
    raise SystemExit(main())
