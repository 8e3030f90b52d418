"""The extension for Visual Studio Code, built by npm in ``.cache/vscode``."""

from __future__ import annotations

import fcntl
import hashlib
import shutil
import subprocess
from pathlib import Path

from lsp_support import REPOSITORY, Unavailable

__all__ = ["EXTENSION", "extension_folder", "npm"]

EXTENSION = REPOSITORY / "editors" / "vscode"
CACHE = REPOSITORY / ".cache" / "vscode"
_NOT_TO_BE_HAD = ("ENOTFOUND", "EAI_AGAIN", "ECONNREFUSED", "ETIMEDOUT", "E404", "ENETUNREACH")


def extension_folder() -> Path:
    """A copy of the extension with its packages.

    Raises:
        Unavailable: they cannot be had here.
    """
    if _node_version() < 20:
        raise Unavailable("needs node 20 or newer, and npm")
    CACHE.mkdir(parents=True, exist_ok=True)
    build = CACHE / "build"
    lock_file = EXTENSION / "package-lock.json"
    made_from = hashlib.sha256(lock_file.read_bytes()).hexdigest()
    stamp = CACHE / "made-from"
    with (CACHE / "lock").open("w") as lock:
        fcntl.flock(lock, fcntl.LOCK_EX)
        build.mkdir(exist_ok=True)
        for file in build.iterdir():
            if file.name != "node_modules":
                shutil.rmtree(file) if file.is_dir() else file.unlink()
        shutil.copytree(
            EXTENSION, build, dirs_exist_ok=True, ignore=shutil.ignore_patterns("node_modules")
        )
        if not (stamp.is_file() and stamp.read_text() == made_from):
            _install(build)
            stamp.write_text(made_from)
    return build


def npm(folder: Path, *arguments: str) -> str:
    done = subprocess.run(
        ["npm", *arguments], cwd=folder, capture_output=True, text=True, timeout=200
    )
    assert done.returncode == 0, done.stdout + done.stderr
    return done.stdout


def _install(build: Path) -> None:
    command = ["npm", "ci", "--ignore-scripts", "--no-audit", "--no-fund"]
    done = subprocess.run(command, cwd=build, capture_output=True, text=True, timeout=280)
    if done.returncode and any(sign in done.stderr for sign in _NOT_TO_BE_HAD):
        raise Unavailable("the packages cannot be had: " + done.stderr.strip().splitlines()[0])
    assert done.returncode == 0, done.stdout + done.stderr


def _node_version() -> int:
    node = shutil.which("node")
    if node is None or shutil.which("npm") is None:
        return 0
    done = subprocess.run([node, "--version"], capture_output=True, text=True)
    return int(done.stdout.removeprefix("v").split(".")[0])
