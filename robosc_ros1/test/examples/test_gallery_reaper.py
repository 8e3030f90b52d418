"""A run of the gallery that is killed leaves no processes."""

from __future__ import annotations

import signal
import subprocess
import sys
from pathlib import Path

import pytest
import reaper
from ros_support import await_condition, state_of

RUN = """
import subprocess, sys, time
import reaper

reaper.watch()
node = subprocess.Popen(["sleep", "600"], start_new_session=True)
print(node.pid, flush=True)
time.sleep(600)
"""


@pytest.mark.parametrize(
    "how", [signal.SIGTERM, signal.SIGINT, signal.SIGHUP, signal.SIGKILL], ids=lambda s: s.name
)
def test_killed_run_leaves_no_node(how: signal.Signals) -> None:
    folder = Path(reaper.__file__).parent
    run = subprocess.Popen(
        [sys.executable, "-c", RUN], cwd=folder, stdout=subprocess.PIPE, text=True
    )
    assert run.stdout is not None
    node = int(run.stdout.readline())
    assert is_running(node)
    run.send_signal(how)
    run.wait()
    run.stdout.close()
    await_condition(lambda: not is_running(node), "the end of the node")


def is_running(process: int) -> bool:
    """Whether there is such a process, and it has not ended."""
    return state_of(process) not in ("", "Z")
