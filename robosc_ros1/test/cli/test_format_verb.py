"""``robosc format``: files in place, ``--check`` for CI."""

from __future__ import annotations

import os
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path

import models
import pytest
from quick import quick_first
from ros_support import SOURCES, Completed

Robosc = Callable[..., Completed]

UNTIDY = "robot   R{component C{\n\n// kept\noutgoing message m with type:none}}"


@pytest.fixture
def file(tmp_path: Path) -> Path:
    path = tmp_path / "model.rscd"
    path.write_text(UNTIDY, encoding="utf-8")
    return path


def test_file_is_changed_once(file: Path, robosc: Robosc) -> None:
    done = robosc("format", "model.rscd")
    assert (done.returncode, done.stdout, done.stderr) == (0, "model.rscd: changed\n", "")
    tidy = file.read_text(encoding="utf-8")
    assert tidy != UNTIDY
    assert "// kept" in tidy
    again = robosc("format", "model.rscd")
    assert (again.returncode, again.stdout) == (0, "")
    assert file.read_text(encoding="utf-8") == tidy


def test_check_changes_nothing_and_tells(file: Path, robosc: Robosc) -> None:
    done = robosc("format", "--check", "model.rscd")
    assert (done.returncode, done.stdout) == (1, "model.rscd: would be changed\n")
    assert file.read_text(encoding="utf-8") == UNTIDY
    robosc("format", "model.rscd")
    assert robosc("format", "--check", "model.rscd").returncode == 0


def test_line_ends_are_kept_and_a_byte_order_mark_is_not(file: Path, robosc: Robosc) -> None:
    robosc("format", "model.rscd")
    tidy = file.read_bytes()
    for kept in (tidy, tidy.replace(b"\n", b"\r\n")):
        file.write_bytes(b"\xef\xbb\xbf" + kept)
        assert robosc("format", "--check", "model.rscd").returncode == 1
        robosc("format", "model.rscd")
        assert file.read_bytes() == kept
        assert robosc("format", "--check", "model.rscd").returncode == 0


def test_mixed_line_ends_are_made_one(file: Path, robosc: Robosc) -> None:
    robosc("format", "model.rscd")
    tidy = file.read_bytes()
    file.write_bytes(tidy.replace(b"\n", b"\r\n", 1))
    robosc("format", "model.rscd")
    assert file.read_bytes() == tidy


@pytest.mark.parametrize("name", quick_first(["-", "/dev/stdin"], 1))
def test_a_pipe_is_read_once_and_written_to_standard_output(
    file: Path, name: str, robosc: Robosc
) -> None:
    command = [sys.executable, "-m", "robosc", "format", name]
    env = os.environ | {"PYTHONPATH": str(SOURCES)}
    done = subprocess.run(command, input=UNTIDY.encode(), capture_output=True, env=env)
    assert (done.returncode, done.stderr) == (0, b"")
    robosc("format", str(file))
    assert done.stdout == file.read_bytes()
    done = subprocess.run(
        [*command, "--check"], input=UNTIDY.encode(), capture_output=True, env=env
    )
    assert (done.returncode, done.stdout.decode()) == (1, f"{name}: would be changed\n")


def test_errors_of_syntax_leave_the_file_and_do_not_stop_the_others(
    file: Path, robosc: Robosc, tmp_path: Path
) -> None:
    broken = tmp_path / "broken.rscd"
    broken.write_text("robot R { component }", encoding="utf-8")
    done = robosc("format", "broken.rscd", "model.rscd")
    assert done.returncode == 1
    assert "broken.rscd:1:" in done.stderr
    assert done.stdout == "model.rscd: changed\n"
    assert broken.read_text(encoding="utf-8") == "robot R { component }"


def test_unknown_names_do_not_matter(robosc: Robosc, tmp_path: Path) -> None:
    (tmp_path / "names.rscd").write_text(models.WITH_ERRORS, encoding="utf-8")
    assert robosc("format", "names.rscd").returncode == 0


def test_missing_file(robosc: Robosc) -> None:
    assert robosc("format", "nowhere.rscd").returncode == 2
