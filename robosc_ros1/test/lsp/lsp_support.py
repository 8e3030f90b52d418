"""Helpers for tests of the language server.

Most tests ask the modules behind the protocol, on texts that have a ``|`` where the cursor is. Those
that speak the protocol need pygls: they lie in ``client/`` and run, in a pytest of their own, in a
virtual environment that :func:`client_python` makes in ``.cache/lsp``.
"""

from __future__ import annotations

import fcntl
import hashlib
import shutil
import subprocess
import sys
import venv
from collections.abc import Sequence
from pathlib import Path

from robosc.lsp.analysis import Analysis, Workspace

__all__ = ["REPOSITORY", "Unavailable", "client_python", "cursor", "open_text"]

HERE = Path(__file__).resolve().parent
REPOSITORY = HERE.parents[2]
CACHE = REPOSITORY / ".cache" / "lsp"
_NOT_TO_BE_HAD = (
    "No matching distribution found",
    "Could not find a version that satisfies",
    "Connection",
    "Temporary failure in name resolution",
)


class Unavailable(Exception):
    """Why there can be no client here."""


def cursor(text: str) -> tuple[str, int]:
    """A text without its mark, and where that was."""
    return text.replace("|", "", 1), text.index("|")


def open_text(workspace: Workspace, path: str | Path, text: str) -> Analysis:
    workspace.put(str(path), text)
    found = workspace.analysis(str(path))
    assert found is not None
    return found


def client_python(requirements: Path = HERE / "requirements.txt", cache: Path = CACHE) -> str:
    """The Python of an environment, made if it is not there or not what it should be.

    Raises:
        Unavailable: its packages cannot be had here.
    """
    cache.mkdir(parents=True, exist_ok=True)
    folder = cache / "venv"
    stamp = folder / "made-from"
    made_from = hashlib.sha256(sys.version.encode() + requirements.read_bytes()).hexdigest()
    with (cache / "lock").open("w") as lock:
        fcntl.flock(lock, fcntl.LOCK_EX)
        if not (stamp.is_file() and stamp.read_text() == made_from):
            shutil.rmtree(folder, ignore_errors=True)
            _make(folder, ["-r", str(requirements)])
            stamp.write_text(made_from)
    return str(folder / "bin" / "python")


def _make(folder: Path, packages: Sequence[str]) -> None:
    try:
        # The system's packages too: robosc's own libraries, and genmsg where there is ROS.
        venv.create(folder, system_site_packages=True, with_pip=True)
    except (subprocess.CalledProcessError, ImportError) as error:
        raise Unavailable(f"no virtual environment (apt install python3-venv): {error}") from error
    pip = [str(folder / "bin" / "python"), "-m", "pip", "install", "--quiet", "--ignore-installed"]
    pip += ["--disable-pip-version-check", "--no-deps", "--only-binary=:all:", *packages]
    done = subprocess.run(pip, capture_output=True, text=True, timeout=600)
    if done.returncode:
        if any(sign in done.stderr for sign in _NOT_TO_BE_HAD):
            errors = [line for line in done.stderr.splitlines() if "ERROR" in line]
            raise Unavailable(f"the packages cannot be had: {errors[-1] if errors else '?'}")
        raise AssertionError(done.stderr)
