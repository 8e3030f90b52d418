"""``check --watch``: again whenever a model or a library beside it is saved, until Ctrl-C."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import pytest
from ros_support import SOURCES

ROBOSC = [sys.executable, "-m", "robosc"]
ROBOT = "robot R {\n    component C from L import C\n    requirement m needs C.%s\n}\n"
LIBRARY = """library L {
    component C {
        incoming message m with type: none
        behaviour { initial marked state %s {} }
    }
}
"""


@contextmanager
def watching(folder: Path, *paths: str) -> Iterator[subprocess.Popen[str]]:
    with subprocess.Popen(
        [*ROBOSC, "check", "--watch", *paths],
        cwd=folder,
        env=os.environ | {"PYTHONPATH": str(SOURCES)},
        stdout=subprocess.PIPE,
        stderr=subprocess.STDOUT,
        text=True,
    ) as process:
        try:
            yield process
        finally:
            process.kill()


def checked(process: subprocess.Popen[str]) -> str:
    """What is printed by one check."""
    assert process.stdout is not None
    lines: list[str] = []
    while not lines or not lines[-1].startswith("checked at "):
        lines.append(process.stdout.readline())
        assert lines[-1], "it ended: " + "".join(lines)
    return "".join(lines)


def save(file: Path, text: str) -> None:
    """As editors do: a new file takes the place of the old one."""
    new = file.with_suffix(".new")
    new.write_text(text)
    os.replace(new, file)  # noqa: PTH105


@pytest.mark.slow
def test_watch(tmp_path: Path) -> None:
    save(tmp_path / "r.rscd", ROBOT % "there")
    save(tmp_path / "l.rscd", LIBRARY % "here")
    with watching(tmp_path, "r.rscd") as process:
        assert "r.rscd:3:27: error[unknown-" in checked(process)
        save(tmp_path / "l.rscd", LIBRARY % "there")
        assert "1 file: 0 errors" in checked(process)
        (tmp_path / "r.rscd").unlink()
        assert "error: cannot read r.rscd" in checked(process)
        save(tmp_path / "r.rscd", ROBOT % "there")
        assert "1 file: 0 errors" in checked(process)
        process.send_signal(signal.SIGINT)
        assert process.wait(timeout=30) == 130


def test_watch_of_a_folder(tmp_path: Path) -> None:
    (tmp_path / "deep").mkdir()
    with watching(tmp_path, ".") as process:
        assert "there is no .rscd file in ." in checked(process)
        save(tmp_path / "deep" / "l.rscd", LIBRARY % "here")
        assert "1 file: 0 errors" in checked(process)
