#!/usr/bin/env python3
"""From the model to a robot that drives: generate, build, start in a ROS graph of its own, sum up.

``./dev demo`` runs this. Everything is made in one folder (``--folder``), a catkin workspace; the
roscore listens on a free port, so that it disturbs no other and none disturbs it. With ``--ros2``
(see ros2_demo.py) it is a colcon workspace, and a domain of its own.
"""

from __future__ import annotations

import argparse
import os
import shutil
import signal
import subprocess
import sys
import time
from pathlib import Path
from typing import Any

from building import (
    HERE,
    ROOT,
    Unavailable,
    environment,
    generate,
    link,
    logged,
    short,
    step,
    summary_in,
)

sys.path.append(str(ROOT / "robosc_ros1" / "test"))
import reaper
import ros2_demo
from free import free_port

PACKAGES = (HERE, HERE.parent / "robot_common")


def main() -> int:
    args = parse_arguments()
    started = time.monotonic()
    reaper.watch()
    signal.signal(signal.SIGINT, signal.SIG_DFL)  # all that was started ends with this process
    try:
        summary = ros2_demo.run(args) if args.ros2 else run(args)
    except Unavailable as reason:
        print(f"demo: {reason}", file=sys.stderr)
        return 1
    except subprocess.CalledProcessError as error:
        print(f"demo: {' '.join(map(str, error.cmd))} failed ({error.returncode})", file=sys.stderr)
        return 1
    if summary is None:
        print("demo: the run ended without a summary; see above", file=sys.stderr)
        return 1
    picture = args.folder / "path.png"
    draw(summary, picture)
    tell(summary, picture, time.monotonic() - started)
    return 1 if violations(summary) or summary["metres"] < args.metres else 0


def run(args: argparse.Namespace) -> dict[str, Any] | None:
    for tool in ("catkin_make", "roslaunch"):
        if shutil.which(tool) is None:
            raise Unavailable(f"{tool} is missing; ./dev setup installs it")
    for package in PACKAGES:
        link(package, args.folder / "src")
    generate(args.folder, "ros1", environment(args.folder))
    build(args.folder)
    return drive(args)


def parse_arguments() -> argparse.Namespace:
    parser = argparse.ArgumentParser(prog="./dev demo", description=__doc__.split("\n")[0])
    parser.add_argument("--ros2", action="store_true", help="on ROS 2: the sourced one, or wheels")
    parser.add_argument("--folder", type=Path, help="default: .cache/demo, .cache/demo_ros2")
    parser.add_argument("--speed", type=float, default=3.0, help="simulated seconds per second")
    parser.add_argument("--seed", type=int, default=1, help="decides which grabs fail")
    parser.add_argument("--metres", type=float, default=12.0, help="how far to drive")
    parser.add_argument(
        "--tolerance", type=float, default=0.1, help="seconds that messages may need"
    )
    parser.add_argument("--seconds", type=float, default=90.0, help="end after this time anyway")
    args = parser.parse_args()
    default = ROOT / ".cache" / ("demo_ros2" if args.ros2 else "demo")
    args.folder = (args.folder or default).resolve()
    return args


def build(folder: Path) -> None:
    step("Build it with catkin_make")
    command = ["catkin_make", "-C", str(folder), f"-DPYTHON_EXECUTABLE={sys.executable}"]
    logged(command, folder, environment(folder))


def drive(args: argparse.Namespace) -> dict[str, Any] | None:
    """Launch robot, controller and observer; the observer's summary, if there is one."""
    report = args.folder / "summary.json"
    report.unlink(missing_ok=True)
    port = free_port()
    step(f"Drive {args.metres:g} m on a roscore of its own, port {port}")
    launch = ["roslaunch", "-p", str(port), "line_follower", "line_follower.launch"]
    values = {
        name: getattr(args, name) for name in ("speed", "seed", "metres", "seconds", "tolerance")
    }
    launch += [f"{name}:={value}" for name, value in values.items()] + [f"report:={report}"]
    env = environment(args.folder) | {"ROS_MASTER_URI": f"http://localhost:{port}"}
    setup = args.folder / "devel" / "setup.sh"
    log = args.folder / "roslaunch.log"
    with log.open("wb") as output:
        process = subprocess.Popen(
            ["/bin/sh", "-c", '. "$0" && exec "$@"', setup, *launch],
            env=env,
            stdout=output,
            stderr=subprocess.STDOUT,
            start_new_session=True,
        )
        try:
            process.wait(timeout=args.seconds + 60)
        finally:
            stop(process)
    return summary_in(report, log)


def stop(process: subprocess.Popen[bytes]) -> None:
    """End roslaunch, which ends its nodes; if it does not, everything that it started."""
    if process.poll() is None:
        process.send_signal(signal.SIGINT)
        try:
            process.wait(timeout=20)
        except subprocess.TimeoutExpired:
            os.killpg(process.pid, signal.SIGKILL)
            process.wait()


def violations(summary: dict[str, Any]) -> int:
    return sum(summary["violations"].values())


def tell(summary: dict[str, Any], picture: Path, seconds: float) -> None:
    step("What happened")
    print(f"  distance driven      {summary['metres']:.1f} m")
    print(f"  stops                {summary['stops']}")
    print(f"  grabs                {summary['grabs']}, {summary['missed_grabs']} failed attempts")
    print(f"  light switches       {summary['light_switches']}")
    judged = f"of {summary['commands_judged']} judgements, tolerance {summary['tolerance']:g} s"
    if summary["late"] > summary["tolerance"] / 2:
        judged += f", {summary['late']:.2f} s more where the machine was late"
    print(f"  violations           {violations(summary)}   ({judged})")
    for rule, count in summary["violations"].items():
        if count:
            print(f"    {rule}: {count}")
    print(f"  picture of the path  {short(picture)}")
    print(f"  time, all in all     {seconds:.0f} s")


def draw(summary: dict[str, Any], picture: Path) -> None:
    import matplotlib

    matplotlib.use("Agg")
    from matplotlib import pyplot

    sys.path.insert(0, str(HERE / "src"))
    from line_follower.world import standard_track

    track = standard_track()
    figure, axes = pyplot.subplots(figsize=(9, 6))
    line = [
        (float("nan"), float("nan")) if track.in_gap(arc) else point
        for arc, point in zip(track.lengths, track.points, strict=False)
    ]
    axes.plot(*zip(*line, strict=True), color="0.75", linewidth=8, label="line")
    axes.plot(*zip(*summary["path"], strict=True), color="tab:blue", label="driven path")
    if summary["grab_places"]:
        axes.plot(*zip(*summary["grab_places"], strict=True), "o", color="tab:red", label="grab")
    axes.set_aspect("equal")
    axes.set_xlabel("x [m]")
    axes.set_ylabel("y [m]")
    axes.set_title(f"{summary['metres']:.1f} m, {violations(summary)} violations")
    axes.legend(loc="center")
    figure.savefig(picture, dpi=120, bbox_inches="tight")


if __name__ == "__main__":
    raise SystemExit(main())
