"""The steps of the demo that are the same on both versions of ROS."""

from __future__ import annotations

import json
import os
import subprocess
import sys
from pathlib import Path
from typing import Any

HERE = Path(__file__).resolve().parent
ROOT = HERE.parents[1]
MODEL = HERE / "line_follower.rscd"


class Unavailable(Exception):
    """Why the demo cannot run on this machine."""


def link(package: Path, sources: Path) -> None:
    sources.mkdir(parents=True, exist_ok=True)
    place = sources / package.name
    if not place.is_symlink():
        place.symlink_to(package)


def generate(folder: Path, target: str, env: dict[str, str]) -> None:
    """The controller of the model, as a package in the workspace's ``src``."""
    step("Generate the controller")
    # Seen from here, the names of files in messages are short.
    output = ["--target", target, "--output", short(folder / "src")]
    command = [sys.executable, "-m", "robosc", "generate", short(MODEL), *output]
    subprocess.run(command, check=True, cwd=ROOT, env=env)


def logged(command: list[str], folder: Path, env: dict[str, str]) -> None:
    """Run what builds; its output is shown if it fails."""
    log = folder / f"{command[0]}.log"
    with log.open("w", encoding="utf-8") as output:
        done = subprocess.run(command, cwd=folder, env=env, stdout=output, stderr=subprocess.STDOUT)
    if done.returncode != 0:
        print(log.read_text(encoding="utf-8"), file=sys.stderr)
    done.check_returncode()


def summary_in(report: Path, log: Path) -> dict[str, Any] | None:
    if not report.is_file():
        print(log.read_text(encoding="utf-8", errors="replace"), file=sys.stderr)
        return None
    summary: dict[str, Any] = json.loads(report.read_text(encoding="utf-8"))
    return summary


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


def short(path: Path) -> Path:
    return path.relative_to(ROOT) if path.is_relative_to(ROOT) else path


def step(title: str) -> None:
    print(f"\n== {title}", flush=True)
