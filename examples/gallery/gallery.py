#!/usr/bin/env python3
"""Lets a robot of the gallery drive: generate its controller, build it, drive it in MuJoCo, sum up.

``./dev gallery NAME`` runs this. ROS 1 is the machine's own; ROS 2 is the test bed of the tests.
"""

from __future__ import annotations

import argparse
import contextlib
import ctypes.util
import fcntl
import hashlib
import itertools
import json
import os
import shutil
import signal
import subprocess
import sys
import time
from collections.abc import Iterator
from pathlib import Path
from typing import Any

HERE = Path(__file__).resolve().parent
ROOT = HERE.parents[1]
CACHE = ROOT / ".cache" / "gallery"
LIBRARIES = CACHE / "lib"
PINS = "mujoco==4.0.0 mujoco-core==4.0.0 glfw==2.11.0 PyOpenGL==3.1.10"
"""What is installed for the gallery alone; numpy is that of each version of ROS."""
INTERFACES = [path.parent for path in sorted(HERE.glob("*/package.xml"))]
COMMON = {"ball", "follow_person", "limiter", "line_follower", "reckless"}
"""The robots that need no interfaces of the gallery's own."""
RATE = 25
"""Hz of the commands: somewhat more than the simulation's steps, so that each step has one."""

sys.path[:0] = [str(ROOT / "robosc_ros1" / "src"), str(ROOT / "robosc_ros1" / "test")]

import reaper  # noqa: E402
from ros2.bed import test_bed  # noqa: E402
from ros2.ros2_support import Graph, free_domain  # noqa: E402
from ros2_bed import GalleryBed  # noqa: E402
from ros_support import Master, Workspace, master, run_robosc  # noqa: E402
from table import Table  # noqa: E402

GUARDED = {"limiter": "limiter", "reckless": "line_follower"}
"""Which model guards what is written by hand."""
SUPERVISED = "/line", "/cmd_vel", "/alive"
"""The topics that those have, which the supervisor passes on."""


def names() -> list[str]:
    """Return the robots of the gallery."""
    found = {path.parent.name for path in HERE.glob("*/*.rscd")}
    return sorted(found - {"libraries"} | {*GUARDED})


def missing() -> str | None:
    """Why nothing can drive here; None if it can. What can be installed without root is."""
    if ctypes.util.find_library("OSMesa") is None:
        return "MuJoCo draws no pictures here (libosmesa6 not found; ./dev gallery installs it)"
    CACHE.mkdir(parents=True, exist_ok=True)
    try:
        with (CACHE / "lock").open("w") as lock:
            fcntl.flock(lock, fcntl.LOCK_EX)
            install()
    except subprocess.CalledProcessError:
        return "MuJoCo could not be installed"
    return None


def install() -> None:
    """Put the simulator's libraries into the cache, once."""
    stamp = LIBRARIES / "pins"
    if stamp.is_file() and stamp.read_text(encoding="utf-8") == PINS:
        return
    shutil.rmtree(LIBRARIES, ignore_errors=True)
    venv = CACHE / "pip"
    subprocess.run([sys.executable, "-m", "venv", "--clear", venv], check=True)
    pip = [venv / "bin" / "pip", "install", "--quiet", "--disable-pip-version-check", "--no-deps"]
    subprocess.run([*pip, "--target", LIBRARIES, *PINS.split()], check=True)
    stamp.write_text(PINS, encoding="utf-8")


def simulation_environment() -> dict[str, str]:
    """What MuJoCo needs besides: pictures without a display, drawn by one thread."""
    return {"MUJOCO_GL": "osmesa", "LP_NUM_THREADS": "0"}


class Ros1:
    """Generated controllers in a catkin workspace, and a master to run them on."""

    def __init__(self, folder: Path, models: Path = HERE) -> None:
        self.folder = folder
        self.workspace = Workspace(folder)
        self.master: Master | None = None
        self._models = models

    def build(self, robots: list[str]) -> None:
        for interfaces in INTERFACES:
            self.workspace.add(interfaces)
        for robot in robots:
            prefixes = {"ROS_PACKAGE_PATH": str(HERE)}
            generate(robot, self._models, self.folder, "ros1", prefixes)
        self.workspace.build()

    @contextlib.contextmanager
    def running(self) -> Iterator[None]:
        (self.folder / "master").mkdir(exist_ok=True)
        with master(self.folder / "master") as self.master:
            yield

    def drive(
        self, robot: str, seed: int, faults: bool, record: Path, metres: float | None = None
    ) -> None:
        """Run one world, or only until its robot has moved so far."""
        assert self.master is not None
        self.master.set("/use_sim_time", True)
        with contextlib.ExitStack() as nodes:
            for command in self._nodes(robot):
                nodes.enter_context(self.workspace.start(*command, master=self.master))
            env = self.workspace.environment("devel", self.master) | simulation_environment()
            env["PYTHONPATH"] = os.pathsep.join((str(HERE), str(LIBRARIES), env["PYTHONPATH"]))
            bridge(sys.executable, 1, (robot, seed, faults, record, metres), env)

    def _nodes(self, robot: str) -> Iterator[tuple[str, ...]]:
        """Yield the commands that start the controller, or the supervisor and what it guards."""
        package = package_of(robot)
        shown = "_publish_events:=true", "_state_rate:=1000"
        if robot not in GUARDED:
            yield "rosrun", package, package, f"_rate:={RATE}", *shown
            return
        yield "rosrun", package, package, "_stop_command:=halt", *shown
        topics = (f"{topic}:=/supervised{topic}" for topic in SUPERVISED)
        yield sys.executable, str(HERE / "physics" / f"{robot}_ros1.py"), *topics


class Ros2:
    """Generated controllers built by colcon, for ROS 2 as the tests have it."""

    def __init__(self, folder: Path, models: Path = HERE) -> None:
        self.folder = folder
        self.bed = GalleryBed(test_bed().folder)
        (folder / "src").mkdir(parents=True, exist_ok=True)
        self.domain = 0
        self._models = models

    def build(self, robots: list[str]) -> None:
        self.bed.complete(with_own=not COMMON.issuperset(robots))
        for robot in robots:
            # With the definitions of ROS 2: those of ROS 1 have other names in a duration.
            prefixes = {"AMENT_PREFIX_PATH": self.bed.environment["AMENT_PREFIX_PATH"]}
            generate(robot, self._models, self.folder, "ros2", prefixes)
        self.bed.run("colcon", "build", folder=self.folder)

    @contextlib.contextmanager
    def running(self) -> Iterator[None]:
        with free_domain() as self.domain:
            yield

    def drive(
        self,
        robot: str,
        seed: int,
        faults: bool,
        record: Path,
        metres: float | None = None,
        awaited: str | None = None,
    ) -> None:
        """Run one world, or only until its robot has moved so far; ``awaited`` is the topic on
        which somebody says that it may begin."""
        package = package_of(robot)
        prefix = self.folder / "install" / package
        (site,) = prefix.glob("lib/python3*/site-packages")
        own = self.bed.environment["PYTHONPATH"]
        path = {"PYTHONPATH": os.pathsep.join((str(site), own))}
        path["AMENT_PREFIX_PATH"] = f"{prefix}:{self.bed.environment['AMENT_PREFIX_PATH']}"
        graph = Graph(self.bed, self.domain, self.folder)
        try:
            values = {"publish_events": "true", "state_rate": 1000, "use_sim_time": "true"}
            values |= {"stop_command": "halt"} if robot in GUARDED else {"rate": RATE}
            words = [prefix / "lib" / package / package, "--ros-args"]
            for name, value in values.items():
                words += ["-p", f"{name}:={value}"]
            graph.start(*words, **path)
            if robot in GUARDED:
                remapped = [word for t in SUPERVISED for word in ("-r", f"{t}:=/supervised{t}")]
                script = HERE / "physics" / f"{robot}_ros2.py"
                graph.start(self.bed.python, script, "--ros-args", *remapped)
            env = graph.environment | simulation_environment()
            env["PYTHONPATH"] = os.pathsep.join((str(HERE), str(LIBRARIES), own))
            bridge(self.bed.python, 2, (robot, seed, faults, record, metres), env, awaited)
        finally:
            graph.close()


def package_of(robot: str) -> str:
    return f"{GUARDED[robot]}_supervisor" if robot in GUARDED else f"{robot}_controller"


def generate(
    robot: str, models: Path, folder: Path, target: str, environment: dict[str, str]
) -> None:
    """Generate the package of a robot into the workspace's ``src``."""
    model = GUARDED.get(robot, robot)
    arguments = ["--target", target, "--mode", "supervisor" if robot in GUARDED else "controller"]
    arguments += ["--output", str(folder / "src"), "--package", package_of(robot)]
    words = ["generate", str(models / model / f"{model}.rscd"), *arguments]
    done = run_robosc(words, folder, environment, tested=False)
    if done.returncode != 0:
        raise SystemExit(done.stderr)


Run = tuple[str, int, bool, Path, float | None]
"""Robot, seed, whether faults are planted, the record to write, and after which way it ends."""


def bridge(
    python: str, version: int, run: Run, env: dict[str, str], awaited: str | None = None
) -> None:
    """Run the bridge to its end; it begins when an Empty came on the topic ``awaited``, if any."""
    robot, seed, faults, record, metres = run
    command = [python, "-m", "physics.bridge", robot, "--controller", package_of(robot)]
    command += ["--ros", str(version), "--seed", str(seed), "--record", str(record)]
    command += ["--faults"] if faults else []
    command += ["--guarded"] if robot in GUARDED else []
    command += ["--metres", str(metres)] if metres else []
    command += ["--awaited", awaited] if awaited else []
    subprocess.run(command, env=env, check=True, timeout=800)


def main() -> int:
    args = parse_arguments()
    reason = missing()
    if reason is not None:
        print(f"gallery: {reason}", file=sys.stderr)
        return 1
    started = time.monotonic()
    robots = args.robots or names()
    reaper.watch()
    signal.signal(signal.SIGINT, signal.SIG_DFL)  # all that was started ends with this process
    kind = Ros1 if args.ros == 1 else Ros2
    ros: Ros1 | Ros2 = kind(CACHE / f"ros{args.ros}")
    stamp, made_from = ros.folder / "made-from", sources(robots)
    if not stamp.is_file() or stamp.read_text(encoding="utf-8") != made_from:
        shutil.rmtree(ros.folder)
        ros = kind(ros.folder)
        ros.build(robots)
        stamp.write_text(made_from, encoding="utf-8")
        print(f"generated and built in {time.monotonic() - started:.0f} s")
    failed, table = False, Table()
    seeds = range(1, args.worlds + 1) if args.worlds else [0]
    with ros.running():
        for seed, robot in itertools.product(seeds, robots):
            if args.table and table.has(args.ros, robot, seed):
                continue
            record = CACHE / f"ros{args.ros}-{robot}-{seed}.json"
            ros.drive(robot, seed, bool(args.worlds), record)
            run = json.loads(record.read_text(encoding="utf-8"))
            failed |= tell(run)
            if args.table:
                table.add(args.ros, run)
            if not args.worlds:
                draw(record)
    return int(failed)


def sources(robots: list[str]) -> str:
    """Return a digest of what the robots' packages are generated and built from."""
    digest = hashlib.sha256(" ".join(robots).encode())
    folders = HERE, ROOT / "robosc_ros1" / "src", ROOT / "robosc_ros1" / "templates"
    others = ".pyc", ".csv", ".md", ".gif"
    for file in sorted(file for folder in folders for file in folder.rglob("*")):
        if file.is_file() and "physics" not in file.parts and file.suffix not in others:
            digest.update(file.read_bytes())
    return digest.hexdigest()


def tell(run: dict[str, Any]) -> bool:
    """Print one run; whether it failed."""
    violations = sum(run["violations"].values())
    print(
        f"{run['world']:15} world {run['seed']:2}  "
        f"{'done  ' if run['succeeded'] else 'FAILED'} after {run['simulated']:5.1f} s "
        f"({run['real']:.1f} s real)  {violations} violations of {run['judgements']} judgements  "
        f"{'; '.join(run['faults'])}{run['violations'] or ''}",
        flush=True,
    )
    return bool(violations) or not run["succeeded"]


def draw(record: Path) -> None:
    """Draw the path and the film of a run beside its record."""
    path, film = record.with_suffix(".png"), record.with_suffix(".gif")
    env = os.environ | simulation_environment()
    env["PYTHONPATH"] = os.pathsep.join((str(HERE), str(LIBRARIES)))
    command = [sys.executable, "-m", "physics.film", record, path, film]
    subprocess.run(command, env=env, check=True, timeout=300)
    print(f"  path {path.relative_to(ROOT)}, film {film.relative_to(ROOT)}")


def parse_arguments() -> argparse.Namespace:
    parser = argparse.ArgumentParser(prog="./dev gallery", description=__doc__.split("\n")[0])
    parser.add_argument("robots", nargs="*", choices=[*names(), []], metavar="NAME")
    parser.add_argument("--ros", type=int, choices=(1, 2), default=1)
    parser.add_argument("--worlds", type=int, default=0, help="so many worlds with planted faults")
    parser.add_argument(
        "--table", action="store_true", help="add the worlds to the README's table but those it has"
    )
    args = parser.parse_args()
    if args.table and not args.worlds:
        parser.error("--table needs --worlds")
    return args


if __name__ == "__main__":
    raise SystemExit(main())
