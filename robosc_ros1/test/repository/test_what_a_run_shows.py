"""What is left out is told in one line, and the count comes last."""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path

import pytest

SHOWN = Path(__file__).with_name("shown.py")


@pytest.mark.parametrize("options", [(), ("-q",), ("-n1",)], ids=str)
def test_what_is_left_out_is_told_in_one_line(options: tuple[str, ...]) -> None:
    done = run(*options)
    assert done.returncode == 0, done.stdout + done.stderr
    *_, left_out, count = done.stdout.splitlines()
    assert left_out == "left out, 3 in all: 3 for there is no such thing (./dev setup installs it)"
    assert "1 passed, 3 skipped" in count


def test_where_changes_are_judged_it_is_a_failure() -> None:
    assert run(CI="true").returncode == pytest.ExitCode.TESTS_FAILED


def run(*options: str, **environment: str) -> subprocess.CompletedProcess[str]:
    command = [sys.executable, "-m", "pytest", "-p", "no:cacheprovider", *options, str(SHOWN)]
    known = {name: value for name, value in os.environ.items() if name != "CI"}
    return subprocess.run(command, env=known | environment, capture_output=True, text=True)
