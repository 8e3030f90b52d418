"""However a run of tests ends, or the demo, it leaves no process and no temporary folder."""

from __future__ import annotations

import contextlib
import os
import signal
import subprocess
import sys
import tempfile
from collections.abc import Callable, Iterator
from pathlib import Path

import pytest
from reaper import GRACE
from ros_support import REPOSITORY, await_condition, missing_ros
from view.browser import missing_browser

LINGERING = Path(__file__).with_name("lingering.py")
ENDS = [signal.SIGINT, signal.SIGTERM, signal.SIGHUP, signal.SIGKILL]


class Run:
    """A run that is to be ended. What it starts has a variable of its own in its environment."""

    def __init__(self, command: list[str], folder: Path) -> None:
        self.told = folder / "told"
        self.told.mkdir()
        # Names of sockets in it are short enough only if its own is.
        self.scratch = Path(tempfile.mkdtemp(prefix="l"))
        self._entry = f"LINGERING={self.told}".encode()
        with (folder / "output").open("wb") as output:
            self.process = subprocess.Popen(
                command,
                env=os.environ | {"LINGERING": str(self.told), "TMPDIR": str(self.scratch)},
                stdout=output,
                stderr=subprocess.STDOUT,
                start_new_session=True,
            )

    def processes(self) -> list[str]:
        """What runs of it and of what it started, whoever started that."""
        found = []
        for process in Path("/proc").glob("[0-9]*"):
            with contextlib.suppress(OSError):  # it has gone, or is somebody else's
                if self._entry in (process / "environ").read_bytes().split(b"\0"):
                    found.append((process / "cmdline").read_text().replace("\0", " "))
        return found

    def await_told(self, name: str) -> None:
        await_condition((self.told / name).exists, name)

    def leaves_nothing(self) -> None:
        self.process.wait()
        await_condition(lambda: not self.processes(), f"an end of {self.processes()}")
        # The process that tidies up does that last.
        await_condition(lambda: not any(self.scratch.iterdir()), "the end of its folder")


Start = Callable[..., Run]


@pytest.fixture
def start(tmp_path: Path) -> Iterator[Start]:
    runs = []

    def start(*tests: str, workers: int = 0) -> Run:
        command = [sys.executable, "-m", "pytest", "-p", "no:cacheprovider", "-q", f"-n{workers}"]
        runs.append(Run(command + [f"{LINGERING}::test_{test}" for test in tests], tmp_path))
        return runs[-1]

    yield start
    for run in runs:
        run.process.kill()
        run.process.wait()


def test_what_has_to_end_has_a_second_to_do_so_after_the_others() -> None:
    assert GRACE < 4  # of the five seconds


@pytest.mark.parametrize("workers", [0, 2])
@pytest.mark.parametrize("how", ENDS, ids=lambda s: s.name)
@pytest.mark.slow
def test_a_run_that_is_ended(start: Start, how: signal.Signals, workers: int) -> None:
    run = start("that_waits", workers=workers)
    run.await_told("waiting")
    run.process.send_signal(how)
    run.leaves_nothing()


def test_a_run_that_is_interrupted(start: Start) -> None:
    run = start("that_waits")
    run.await_told("waiting")
    run.process.send_signal(signal.SIGINT)
    run.leaves_nothing()


@pytest.mark.slow
def test_a_worker_that_crashes(start: Start) -> None:
    """What it started ends at once, not with the run."""
    run = start("that_waits", "that_kills_its_worker", workers=2)
    run.await_told("killed")
    run.await_told("waiting")
    killed = str(run.told / "killed")
    await_condition(lambda: not any(killed in p for p in run.processes()), "the end of its process")
    assert run.process.poll() is None and run.processes()
    run.process.terminate()
    run.leaves_nothing()


@pytest.mark.slow
def test_a_test_that_takes_too_long(start: Start) -> None:
    run = start("that_takes_too_long")
    run.await_told("late")
    assert run.process.wait() == pytest.ExitCode.TESTS_FAILED
    await_condition(lambda: not run.processes(), "the end of its process")
    # Whoever looks for the cause finds its files until the next run.
    assert any(run.scratch.glob("*/pytest-of-*/*/*/file"))


@pytest.mark.once
@pytest.mark.parametrize("how", ENDS[:3], ids=lambda s: s.name)
def test_a_run_with_a_master_and_a_browser(start: Start, how: signal.Signals) -> None:
    reason = missing_ros() or missing_browser()
    if reason is not None:
        pytest.skip(reason)
    run = start("with_a_master_and_a_browser", workers=1)
    run.await_told("real")
    assert sum("rosmaster" in p for p in run.processes()) == 2  # the master, and what it comes from
    assert any("chrom" in p for p in run.processes())
    run.process.send_signal(how)
    run.leaves_nothing()


@pytest.mark.slow
@pytest.mark.parametrize("how", ENDS[:3], ids=lambda s: s.name)
def test_a_demo_that_is_ended(ros: None, how: signal.Signals, tmp_path: Path) -> None:
    demo = str(REPOSITORY / "examples" / "line_follower" / "demo.py")
    run = Run([sys.executable, demo, "--folder", str(tmp_path / "demo")], tmp_path)
    try:
        await_condition(
            lambda: (
                run.process.poll() is not None
                or any("line_follower_controller" in p for p in run.processes())
            ),
            "a controller that drives",
            seconds=600,
        )
        assert run.process.poll() is None, (tmp_path / "output").read_text(encoding="utf-8")
        run.process.send_signal(how)
        run.leaves_nothing()
    finally:
        run.process.kill()
