"""Ends what a run of the gallery or of benchmarks leaves behind when it is killed: nodes, a
roscore, simulators.

They are in sessions of their own and would stay. So a process waits at the other end of a pipe that
closes with the run, however it ends, and then ends all that has the run's mark in its environment.
"""

from __future__ import annotations

import contextlib
import os
import signal
import subprocess
import sys
import time
import uuid
from collections.abc import Iterator
from pathlib import Path

__all__ = ["MARK", "watch"]

MARK = "ROBOSC_RUN"
"""The environment variable that marks a run's processes."""
GRACE = 10.0
"""Seconds that they have to end by themselves."""


def watch() -> None:
    """Mark this process and all that it starts from now on, and have them ended with it."""
    mark = f"{os.getpid()}-{uuid.uuid4()}"
    subprocess.Popen(
        [sys.executable, __file__, mark],
        stdin=subprocess.PIPE,
        start_new_session=True,
        env={name: value for name, value in os.environ.items() if name != MARK},
    )
    os.environ[MARK] = mark


def marked(mark: str) -> Iterator[int]:
    """Yield the processes of a run."""
    entry = f"{MARK}={mark}".encode()
    for folder in Path("/proc").glob("[0-9]*"):
        with contextlib.suppress(OSError):  # it has gone, or is somebody else's
            if entry in (folder / "environ").read_bytes().split(b"\0"):
                yield int(folder.name)


def end(mark: str) -> None:
    """End the processes of a run, and those that they start meanwhile."""
    deadline = time.monotonic() + GRACE
    told: set[int] = set()
    while processes := set(marked(mark)):
        late = time.monotonic() > deadline
        for process in processes if late else processes - told:
            with contextlib.suppress(ProcessLookupError):
                os.kill(process, signal.SIGKILL if late else signal.SIGTERM)
        told |= processes
        time.sleep(0.05)


if __name__ == "__main__":
    sys.stdin.read()
    end(sys.argv[1])
