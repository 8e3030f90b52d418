"""``./dev demo --ros2``: the same on ROS 2, in a domain that nobody else uses.

ROS 2 is the one that is sourced. Where none is, it is that of the tests: rclpy and what belongs to
it as wheels, in .cache/ros2 (x86-64 only).
"""

from __future__ import annotations

import argparse
import os
import shutil
import signal
import subprocess
from pathlib import Path
from typing import Any

from building import (
    HERE,
    Unavailable,
    environment,
    generate,
    link,
    logged,
    step,
    summary_in,
)
from free import free_domain

CONTROLLER = "line_follower_controller"


def run(args: argparse.Namespace) -> dict[str, Any] | None:
    args.folder.mkdir(parents=True, exist_ok=True)
    env, python = ros(args.folder)
    generate(args.folder, "ros2", os.environ | environment(args.folder))
    step("Build it with colcon")
    logged(["colcon", "build"], args.folder, env)
    with free_domain() as domain:
        step(f"Drive {args.metres:g} m in domain {domain}")
        return drive(args, env | {"ROS_DOMAIN_ID": str(domain)}, python)


def ros(folder: Path) -> tuple[dict[str, str], str]:
    """The environment of a ROS 2 that has the example's interfaces, or will have; its Python."""
    if os.environ.get("ROS_VERSION") == "2":
        if shutil.which("colcon") is None:
            raise Unavailable("colcon is missing: apt install python3-colcon-common-extensions")
        link(HERE.parent / "robot_common", folder / "src")
        return dict(os.environ), "python3"
    from ros2 import bed

    print(
        "no ROS 2 is sourced: taking that of the tests; the first time that takes minutes",
        flush=True,
    )
    try:
        made = bed.test_bed()
    except bed.Unavailable as reason:
        raise Unavailable(f"source a ROS 2 first; there are no wheels of it: {reason}") from None
    return made.environment, made.python


def drive(args: argparse.Namespace, env: dict[str, str], python: str) -> dict[str, Any] | None:
    """Start controller, robot and observer; the observer's summary, if there is one."""
    report, log = args.folder / "summary.json", args.folder / "nodes.log"
    report.unlink(missing_ok=True)
    controller = args.folder / "install" / CONTROLLER / "lib" / CONTROLLER / CONTROLLER
    robot, observer = (HERE / "nodes" / f"{n}_ros2.py" for n in ("simulated_robot", "observer"))
    given = {"speed": args.speed, "seed": args.seed, "listeners": 2, "awaits_switch": True}
    asked = {n: getattr(args, n) for n in ("metres", "seconds", "tolerance")} | {"report": report}
    # Steer as often per simulated second, however fast the simulation runs.
    pace = {"rate": 10.0 * args.speed}
    setup = args.folder / "install" / "setup.sh"
    nodes = []
    with log.open("wb") as output:
        try:
            for command, values in (
                ([controller], pace), ([python, robot], given), ([python, observer], asked),
            ):  # fmt: skip
                words = ["--ros-args", *(w for n, v in values.items() for w in ("-p", f"{n}:={v}"))]
                shell = ["/bin/sh", "-c", '. "$0" && exec "$@"', setup, *command, *words]
                node = subprocess.Popen(
                    shell, env=env, stdout=output, stderr=subprocess.STDOUT, cwd=args.folder
                )
                nodes.append(node)
            nodes[-1].wait(timeout=args.seconds + 60)
        finally:
            for node in nodes:
                node.send_signal(signal.SIGINT)
            for node in nodes:
                try:
                    node.wait(timeout=10)
                except subprocess.TimeoutExpired:
                    node.kill()
    return summary_in(report, log)
