"""What a verb writes replaces what was there at once, or not at all."""

from __future__ import annotations

import os
import resource
import stat
import subprocess
import sys
from pathlib import Path

import pytest
from ros_support import SOURCES

from robosc.emit.write.whole_file import write_whole

UNTIDY = "robot   R{component C{outgoing message m with type:none}}\n"


def full() -> None:
    """No file of this process has room for more."""
    resource.setrlimit(resource.RLIMIT_FSIZE, (8, 8))


@pytest.mark.parametrize(
    ("verb", "kept"),
    [
        (["format", "model.rscd"], "model.rscd"),
        (["export", "model.rscd", "--format", "json", "--output", "old.json"], "old.json"),
        (["report", "model.rscd", "--output", "old.json"], "old.json"),
        (["new", "Rover"], "model.rscd"),
    ],
    ids=lambda p: p[0] if isinstance(p, list) else "",
)
def test_what_is_there_stays_where_there_is_no_room(
    verb: list[str], kept: str, tmp_path: Path
) -> None:
    for name in {"model.rscd", kept}:
        (tmp_path / name).write_text(UNTIDY)
    before = sorted(p.name for p in tmp_path.iterdir())
    command = [sys.executable, "-m", "robosc", *verb]
    path = {**os.environ, "PYTHONPATH": str(SOURCES)}
    done = subprocess.run(
        command, cwd=tmp_path, env=path, preexec_fn=full, stderr=subprocess.PIPE, check=False
    )
    assert (done.returncode, b"cannot write" in done.stderr) == (2, True)
    assert (tmp_path / kept).read_text() == UNTIDY
    assert sorted(p.name for p in tmp_path.iterdir()) == before


def test_links_and_permissions_stay(tmp_path: Path) -> None:
    file, link = tmp_path / "file", tmp_path / "link"
    file.write_text("before")
    file.chmod(0o751)
    link.symlink_to(file.name)
    write_whole(link, b"after")
    assert link.is_symlink() and file.read_text() == "after"
    assert stat.S_IMODE(file.stat().st_mode) == 0o751


def test_a_pipe_is_written_as_it_is(tmp_path: Path) -> None:
    pipe = tmp_path / "pipe"
    os.mkfifo(pipe)
    reader = os.open(pipe, os.O_RDONLY | os.O_NONBLOCK)
    write_whole(pipe, b"text")
    assert os.read(reader, 10) == b"text" and pipe.is_fifo()
    os.close(reader)
