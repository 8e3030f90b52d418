"""Completion in a shell, as bash asks for it: through the protocol of argcomplete."""

from __future__ import annotations

import os
import subprocess
import sys
import tempfile
from pathlib import Path

import pytest
from ros_support import SOURCES

pytest.importorskip("argcomplete")

ROBOSC = [sys.executable, "-m", "robosc"]


def completed(line: str, folder: Path) -> set[str]:
    """What may follow at the end of a command line."""
    with tempfile.NamedTemporaryFile(mode="r") as answer:
        environment = os.environ | {
            "PYTHONPATH": str(SOURCES),
            "_ARGCOMPLETE": "1",
            "_ARGCOMPLETE_IFS": "\n",
            "_ARGCOMPLETE_STDOUT_FILENAME": answer.name,
            "COMP_LINE": line,
            "COMP_POINT": str(len(line)),
        }
        assert subprocess.run(ROBOSC, cwd=folder, env=environment).returncode == 0
        return {word.strip() for word in answer.read().split("\n") if word.strip()}


def test_completion(tmp_path: Path) -> None:
    (tmp_path / "rover.rscd").touch()
    assert completed("robosc che", tmp_path) == {"check"}
    assert {"--force", "--diff"} <= completed("robosc generate --", tmp_path)
    assert completed("robosc generate --target ", tmp_path) == {"ros1", "ros2"}
    assert completed("robosc explain never-", tmp_path) == {"never-allowed"}
    assert completed("robosc check ro", tmp_path) == {"rover.rscd"}
