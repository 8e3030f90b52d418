"""What the sizes of a run take; see sizes.py."""

from __future__ import annotations

import subprocess
import sys
from functools import cache

import costs
import pytest
import sizes
from ros_support import REPOSITORY

FILES = (
    "ros1/test_order_example.py",
    "ros2/test_ros2_order_example.py",
    "ros2/test_ros2_ends.py",
    "simulate/test_terminal.py",
    "emit/test_cif.py",
)


@cache
def collected(size: str) -> frozenset[str]:
    command = [sys.executable, "-m", "pytest", "-p", "no:cacheprovider", "--collect-only", "-q"]
    files = [f"robosc_ros1/test/{file}" for file in FILES]
    done = subprocess.run(
        [*command, f"--size={size}", *files], cwd=REPOSITORY, capture_output=True, text=True
    )
    assert done.returncode == 0, done.stdout + done.stderr
    return frozenset(line for line in done.stdout.splitlines() if "::" in line)


@pytest.mark.slow
def test_the_rest_is_what_the_usual_run_leaves_out() -> None:
    quick, usual, rest, all_of_them = map(collected, sizes.SIZES)
    assert quick < usual and usual | rest == all_of_them and not usual & rest


@pytest.mark.slow
def test_one_of_two_twins_and_one_of_many_cases_are_usual() -> None:
    orders = [test for test in collected("usual") if "test_an_order_is_carried_out" in test]
    assert len(orders) == 1
    ends = {test for test in collected("all") if "test_shutdown_cancels_goals" in test}
    assert len(ends) == 3 and len(ends & collected("usual")) == 1
    lines = {test for test in collected("usual") if "test_events_are_typed" in test}
    assert len(lines) == 1


@pytest.mark.slow
def test_of_a_function_with_many_cases_a_quick_run_takes_some() -> None:
    name = "emit/test_cif.py::test_random_data_become_enumerations"
    assert costs.read(costs.KEPT)[name].processor > sizes.OF_ALL_CASES
    quick, usual = ({t for t in collected(size) if name in t} for size in ("quick", "usual"))
    assert len(quick) < len(usual)
