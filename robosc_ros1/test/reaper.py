"""Ends what a run leaves behind when it is killed: nodes, a roscore, browsers, its temporary folder.

They are in sessions of their own and would stay. So a process waits for the end of the run, however
it ends, and then ends all that has the run's mark in its environment. Runs may be nested: what the
inner one marks has the outer one's mark, too.
"""

from __future__ import annotations

import contextlib
import os
import select
import shutil
import signal
import subprocess
import sys
import time
import uuid
from collections.abc import Iterator
from pathlib import Path

__all__ = ["KEEP", "MARK", "end", "watch"]

MARK = "ROBOSC_RUN"
"""The environment variable that marks a run's processes."""
KEEP = "keep"
"""A file of this name in the run's temporary folder keeps the folder."""
GRACE = 2.5
"""Seconds that they have to end by themselves."""


def watch(scratch: Path | None = None) -> str:
    """Mark this process and all that it starts from now on, and have them ended with it.

    Where ``scratch`` is given, it is the run's temporary folder, and goes with it. Ctrl-C and a closed
    terminal end this process, even where it was started in the background. Returns the mark.
    """
    if signal.getsignal(signal.SIGINT) is signal.SIG_IGN:
        signal.signal(signal.SIGINT, signal.default_int_handler)
    signal.signal(signal.SIGHUP, signal.SIG_DFL)  # ignored under nohup
    mark = "/".join(filter(None, (os.environ.get(MARK), f"{os.getpid()}-{uuid.uuid4()}")))
    watcher = subprocess.Popen(
        [sys.executable, "-I", "-S", __file__, mark, str(os.getpid()), scratch or ""],
        stdin=subprocess.DEVNULL,
        start_new_session=True,
        env={name: value for name, value in os.environ.items() if name != MARK},
    )
    watcher.returncode = 0  # it outlives this process, and nobody waits for it
    os.environ[MARK] = mark
    return mark


def marked(mark: str) -> Iterator[int]:
    """Yield the processes of a run."""
    entry = f"{MARK}={mark}".encode()
    for folder in Path("/proc").glob("[0-9]*"):
        with contextlib.suppress(OSError):  # it has gone, or is somebody else's
            for found in (folder / "environ").read_bytes().split(b"\0"):
                if found == entry or found.startswith(entry + b"/"):
                    yield int(folder.name)


def end(mark: str) -> None:
    """End the processes of a run, and those that they start meanwhile."""
    deadline = time.monotonic() + GRACE
    told: set[int] = set()
    while processes := set(marked(mark)) - {os.getpid()}:
        late = time.monotonic() > deadline
        for process in processes if late else processes - told:
            with contextlib.suppress(ProcessLookupError):
                os.kill(process, signal.SIGKILL if late else signal.SIGTERM)
        told |= processes
        time.sleep(0.05)


def await_end(process: int) -> None:
    """Wait until a process has ended, which may have been long ago."""
    with contextlib.suppress(ProcessLookupError):
        waiting = select.poll()
        waiting.register(os.pidfd_open(process), select.POLLIN)
        waiting.poll()


def main(mark: str, process: int, scratch: str) -> None:
    await_end(process)
    end(mark)
    if scratch and not Path(scratch, KEEP).exists():
        shutil.rmtree(scratch, ignore_errors=True)


if __name__ == "__main__":
    main(sys.argv[1], int(sys.argv[2]), sys.argv[3])
