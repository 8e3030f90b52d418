"""Two checkouts can run their tests at once: they take no port and no ROS domain twice."""

from __future__ import annotations

import os
import subprocess
import sys
from itertools import chain
from pathlib import Path

import free
import pytest
from free import free_domain, free_port, taken
from ros_support import await_condition

OTHER = """
import sys
from free import free_domain, free_port
port = free_port()
with free_domain() as domain:
    print(port, domain, flush=True)
    sys.stdin.read()
"""


def test_what_another_process_has_is_not_taken_until_it_has_ended(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    with subprocess.Popen(
        [sys.executable, "-c", OTHER],
        cwd=Path(free.__file__).parent,
        stdin=subprocess.PIPE,
        stdout=subprocess.PIPE,
        text=True,
    ) as other:
        assert other.stdin is not None and other.stdout is not None
        port, domain = map(int, other.stdout.readline().split())
        with free_domain() as own:
            assert own != domain
        assert taken(f"domain-{domain}") is None
        wanted = chain([port], range(20000, 32768))
        monkeypatch.setattr(free.random.SystemRandom, "randrange", lambda *_: next(wanted))
        assert free_port() != port
        other.stdin.close()
    lock = await_condition(lambda: taken(f"port-{port}"), "the end of what has the port")
    lock.close()


def test_two_runs_have_temporary_folders_of_their_own(tmp_path: Path) -> None:
    command = [sys.executable, "-m", "pytest", "-p", "no:cacheprovider", "-q", "-s"]
    shown = Path(__file__).with_name("shown.py")
    known = {name: value for name, value in os.environ.items() if name != "CI"}
    runs = [
        subprocess.Popen([*command, shown], stdout=subprocess.PIPE, text=True, env=known)
        for _ in range(2)
    ]
    folders = set()
    for run in runs:
        output, _ = run.communicate()
        assert run.returncode == 0, output
        folders |= {line for line in output.splitlines() if line.startswith("folder ")}
    assert len(folders) == 2
