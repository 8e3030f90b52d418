"""The extension for Visual Studio Code, built by npm in ``.cache/vscode``."""

from __future__ import annotations

import fcntl
import hashlib
import shutil
import subprocess
from collections.abc import Sequence
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
    build, packages = CACHE / "build", CACHE / "made-from"
    sources = CACHE / "copied-from"
    files = sorted(f for f in EXTENSION.rglob("*") if f.is_file() and "node_modules" not in f.parts)
    with (CACHE / "lock").open("w") as lock:
        fcntl.flock(lock, fcntl.LOCK_EX)
        build.mkdir(exist_ok=True)
        # Another run of the tests may be packing it: it is copied anew only if it has changed.
        if not _holds(sources, files):
            for file in build.iterdir():
                if file.name != "node_modules":
                    shutil.rmtree(file) if file.is_dir() else file.unlink()
            ignored = shutil.ignore_patterns("node_modules")
            shutil.copytree(EXTENSION, build, dirs_exist_ok=True, ignore=ignored)
            sources.write_text(_digest(files))
        lock_file = [EXTENSION / "package-lock.json"]
        if not _holds(packages, lock_file):
            _install(build)
            packages.write_text(_digest(lock_file))
    return build


def _holds(stamp: Path, files: Sequence[Path]) -> bool:
    return stamp.is_file() and stamp.read_text() == _digest(files)


def _digest(files: Sequence[Path]) -> str:
    content = b"".join(str(f).encode() + b"\0" + f.read_bytes() for f in files)
    return hashlib.sha256(content).hexdigest()


def npm(folder: Path, *arguments: str) -> str:
    done = subprocess.run(
        ["npm", *arguments], cwd=folder, capture_output=True, text=True, timeout=600
    )
    assert done.returncode == 0, done.stdout + done.stderr
    return done.stdout


def _install(build: Path) -> None:
    command = ["npm", "ci", "--ignore-scripts", "--no-audit", "--no-fund"]
    done = subprocess.run(command, cwd=build, capture_output=True, text=True, timeout=600)
    if done.returncode and any(sign in done.stderr for sign in _NOT_TO_BE_HAD):
        raise Unavailable("the packages cannot be had: " + done.stderr.strip().splitlines()[0])
    assert done.returncode == 0, done.stdout + done.stderr


def _node_version() -> int:
    node = shutil.which("node")
    if node is None or shutil.which("npm") is None:
        return 0
    done = subprocess.run([node, "--version"], capture_output=True, text=True)
    return int(done.stdout.removeprefix("v").split(".")[0])
