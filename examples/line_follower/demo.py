#!/usr/bin/env python3
"""From the model to a robot that drives: generate, build, launch on an own roscore, sum up.

``./dev demo`` runs this. Everything is made in one folder (``--folder``), a catkin workspace; the
roscore listens on a free port, so that it disturbs no other and none disturbs it.
"""

from __future__ import annotations

import argparse
import json
import os
import shutil
import signal
import socket
import subprocess
import sys
import time
from pathlib import Path
from typing import Any

HERE = Path(__file__).resolve().parent
ROOT = HERE.parents[1]
sys.path.append(str(ROOT / "robosc_ros1" / "test"))
import reaper  # noqa: E402

MODEL = HERE / "line_follower.rscd"
PACKAGES = (HERE, HERE.parent / "robot_common")


def main() -> int:
    args = parse_arguments()
    started = time.monotonic()
    reaper.watch()
    signal.signal(signal.SIGINT, signal.SIG_DFL)  # all that was started ends with this process
    for tool in ("catkin_make", "roslaunch"):
        if shutil.which(tool) is None:
            print(f"demo: {tool} is missing; ./dev setup installs it", file=sys.stderr)
            return 1
    try:
        generate(args.folder)
        build(args.folder)
        summary = drive(args)
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


def parse_arguments() -> argparse.Namespace:
    parser = argparse.ArgumentParser(prog="./dev demo", description=__doc__.split("\n")[0])
    parser.add_argument("--folder", type=Path, default=ROOT / ".cache" / "demo")
    parser.add_argument("--speed", type=float, default=3.0, help="simulated seconds per second")
    parser.add_argument("--seed", type=int, default=1, help="decides which grabs fail")
    parser.add_argument("--metres", type=float, default=12.0, help="how far to drive")
    parser.add_argument("--seconds", type=float, default=90.0, help="end after this time anyway")
    args = parser.parse_args()
    args.folder = args.folder.resolve()
    return args


def generate(folder: Path) -> None:
    """The controller of the model, as a package in the workspace's ``src``."""
    sources = folder / "src"
    sources.mkdir(parents=True, exist_ok=True)
    for package in PACKAGES:
        link = sources / package.name
        if not link.is_symlink():
            link.symlink_to(package)
    step("Generate the controller")
    # Seen from here, the names of files in messages are short.
    command = [sys.executable, "-m", "robosc", "generate", short(MODEL), "--output", short(sources)]
    subprocess.run(command, check=True, cwd=ROOT, env=environment(folder))


def build(folder: Path) -> None:
    step("Build it with catkin_make")
    command = ["catkin_make", "-C", str(folder), f"-DPYTHON_EXECUTABLE={sys.executable}"]
    log = folder / "catkin_make.log"
    with log.open("w", encoding="utf-8") as output:
        done = subprocess.run(
            command, env=environment(folder), stdout=output, stderr=subprocess.STDOUT
        )
    if done.returncode != 0:
        print(log.read_text(encoding="utf-8"), file=sys.stderr)
    done.check_returncode()


def drive(args: argparse.Namespace) -> dict[str, Any] | None:
    """Launch robot, controller and observer; the observer's summary, if there is one."""
    report = args.folder / "summary.json"
    report.unlink(missing_ok=True)
    port = free_port()
    step(f"Drive {args.metres:g} m on a roscore of its own, port {port}")
    launch = ["roslaunch", "-p", str(port), "line_follower", "line_follower.launch"]
    values = {name: getattr(args, name) for name in ("speed", "seed", "metres", "seconds")}
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
    if not report.is_file():
        print(log.read_text(encoding="utf-8", errors="replace"), file=sys.stderr)
        return None
    summary: dict[str, Any] = json.loads(report.read_text(encoding="utf-8"))
    return summary


def stop(process: subprocess.Popen[bytes]) -> None:
    """End roslaunch, which ends its nodes; if it does not, everything that it started."""
    if process.poll() is None:
        process.send_signal(signal.SIGINT)
        try:
            process.wait(timeout=20)
        except subprocess.TimeoutExpired:
            os.killpg(process.pid, signal.SIGKILL)
            process.wait()


def environment(folder: Path) -> dict[str, str]:
    env = dict(os.environ)
    python = Path(sys.executable).parent
    env["PATH"] = f"{python}{os.pathsep}{env.get('PATH', os.defpath)}"
    sources = str(ROOT / "robosc_ros1" / "src")
    env["PYTHONPATH"] = os.pathsep.join(filter(None, [sources, env.get("PYTHONPATH")]))
    env["ROS_LOG_DIR"] = str(folder / "log")
    env["ROS_HOME"] = str(folder / "ros_home")
    env.pop("ROS_IP", None)
    env["ROS_HOSTNAME"] = "localhost"
    return env


def free_port() -> int:
    with socket.socket() as probe:
        probe.bind(("localhost", 0))
        port: int = probe.getsockname()[1]
        return port


def violations(summary: dict[str, Any]) -> int:
    return sum(summary["violations"].values())


def tell(summary: dict[str, Any], picture: Path, seconds: float) -> None:
    step("What happened")
    print(f"  distance driven      {summary['metres']:.1f} m")
    print(f"  stops                {summary['stops']}")
    print(f"  grabs                {summary['grabs']}, {summary['missed_grabs']} failed attempts")
    print(f"  light switches       {summary['light_switches']}")
    judged = f"of {summary['commands_judged']} judgements, tolerance {summary['tolerance']:g} s"
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


def short(path: Path) -> Path:
    return path.relative_to(ROOT) if path.is_relative_to(ROOT) else path


def step(title: str) -> None:
    print(f"\n== {title}", flush=True)


if __name__ == "__main__":
    raise SystemExit(main())
