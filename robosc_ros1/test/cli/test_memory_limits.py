"""Under ``ulimit -v`` a command takes what it may, or ends with exit code 4 and says why."""

from __future__ import annotations

import os
import resource
import subprocess
import sys
from pathlib import Path

import pytest
from families import switches
from ros_support import SOURCES

from robosc.errors import OUT_OF_MEMORY
from robosc.synthesis.bdd.manager import available

LIMIT = 10**9
"""Bytes of address space: enough for the explicit engine, not for the threads of the other one."""

needs_library = pytest.mark.skipif(not available(), reason="needs oxidd")


@pytest.fixture
def large(tmp_path: Path) -> Path:
    """A model with 2^36 states, which hang together."""
    command = "component Arm { incoming message go with type: none }"
    command += "".join(f" requirement go needs S{i}.x or S{i + 1}.x" for i in range(35))
    path = tmp_path / "large.rscd"
    path.write_text(f"robot Large {{ {switches(36)} {command} }}", encoding="utf-8")
    return path


def limited(*arguments: str, limit: int = LIMIT) -> tuple[int, str]:
    """The exit code of a command that may take no more than the limit, and what it complains of."""
    path = os.pathsep.join([str(SOURCES), *sys.path])
    done = subprocess.run(
        [sys.executable, "-m", "robosc", *arguments],
        env=os.environ | {"PYTHONPATH": path, "OPENBLAS_NUM_THREADS": "1"},
        capture_output=True,
        text=True,
        preexec_fn=lambda: resource.setrlimit(resource.RLIMIT_AS, (limit, limit)),
    )
    return done.returncode, done.stderr


def test_what_the_explicit_engine_does_is_done_by_it(tmp_path: Path) -> None:
    path = tmp_path / "small.rscd"
    path.write_text(f"robot Small {{ {switches(13)} }}", encoding="utf-8")
    assert limited("synthesize", str(path))[0] == 0


@needs_library
def test_the_symbolic_engine_says_how_much_is_missing(large: Path) -> None:
    found, errors = limited("synthesize", "--engine", "bdd", str(large))
    assert found == 4
    assert errors.splitlines()[-1].startswith("error: the symbolic engine has too little memory")


@needs_library
def test_what_only_the_symbolic_engine_does_is_refused(large: Path) -> None:
    found, errors = limited("synthesize", str(large))
    assert found == 4
    assert "or give the symbolic engine more memory" in errors.splitlines()[-1]


def test_what_does_not_fit_at_all_is_no_traceback(tmp_path: Path) -> None:
    path = tmp_path / "blank.rscd"
    path.write_bytes(b"\n" * (60 * 2**20))
    found, errors = limited("check", str(path), limit=2 * 10**8)
    assert (found, errors) == (4, f"error: {OUT_OF_MEMORY}\n")
