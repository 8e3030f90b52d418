"""Tests that leave behind what they started; test_nothing_is_left.py runs them and ends the run."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
import time
from pathlib import Path

import pytest
import ros_support
from view.browser import headless

STUBBORN = """
import signal, sys, time
signal.signal(signal.SIGTERM, signal.SIG_IGN)
signal.signal(signal.SIGINT, signal.SIG_IGN)
open(sys.argv[1], "w").close()
time.sleep(600)
"""


def linger(name: str, tmp_path: Path) -> None:
    """Leave a process that ends for nobody, in a session of its own, and a file; tell of both."""
    (tmp_path / "file").touch()
    told = Path(os.environ["LINGERING"], name)
    subprocess.Popen([sys.executable, "-c", STUBBORN, told], start_new_session=True)
    ros_support.await_condition(told.exists, "the process that stays")


def test_that_waits(tmp_path: Path) -> None:
    linger("waiting", tmp_path)
    time.sleep(600)


def test_that_kills_its_worker(tmp_path: Path) -> None:
    linger("killed", tmp_path)
    os.kill(os.getpid(), signal.SIGKILL)


@pytest.mark.timeout(1)
def test_that_takes_too_long(tmp_path: Path) -> None:
    linger("late", tmp_path)
    time.sleep(600)


def test_with_a_master_and_a_browser(tmp_path: Path) -> None:
    folder = tmp_path / "browser"
    folder.mkdir()
    with ros_support.master(tmp_path), headless(folder):
        linger("real", tmp_path)
        time.sleep(600)
