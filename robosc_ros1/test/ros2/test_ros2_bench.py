"""A benchmark that is ended leaves none of its nodes running."""

from __future__ import annotations

import contextlib
import shutil
import signal
import subprocess
import sys
from pathlib import Path

import pytest
from ros2.bed import Bed
from ros_support import REPOSITORY, await_condition


@pytest.mark.parametrize("how", [signal.SIGTERM, signal.SIGKILL], ids=lambda s: s.name)
def test_a_benchmark_that_is_ended_leaves_no_node(how: signal.Signals, bed: Bed) -> None:
    command = [sys.executable, str(REPOSITORY / "robosc_ros1" / "bench"), "ros2"]
    run = subprocess.Popen(command, stdout=subprocess.DEVNULL)

    def folders() -> list[Path]:
        """Where its nodes are running: those with its mark, within that of the run of tests."""
        found = []
        for process in Path("/proc").glob("[0-9]*"):
            with contextlib.suppress(OSError):  # it has gone, or is somebody else's
                if f"/{run.pid}-".encode() in (process / "environ").read_bytes():
                    found.append((process / "cwd").readlink())
        return found

    try:
        await_condition(lambda: run.poll() is not None or len(folders()) == 3, "all of its nodes")
        assert run.poll() is None
        folder = folders()[0]
    finally:
        run.send_signal(how)
        run.wait()
    await_condition(lambda: folders() == [], "the end of the nodes")
    # One that is not killed outright removes its files by itself.
    assert folder.exists() == (how is signal.SIGKILL)
    shutil.rmtree(folder, ignore_errors=True)
