"""``generate --diff``: what would be written, while nothing is."""

from __future__ import annotations

import subprocess
from collections.abc import Callable
from pathlib import Path

from ros_support import EXAMPLES, Completed

Robosc = Callable[..., Completed]
DOOR = EXAMPLES / "door" / "door.rscd"


def tree(folder: Path) -> dict[Path, bytes]:
    return {path: path.read_bytes() for path in folder.rglob("*") if path.is_file()}


def test_a_package_that_is_not_there(robosc: Robosc, tmp_path: Path) -> None:
    done = robosc("generate", str(DOOR), "--diff")
    assert done.returncode == 1
    assert "--- /dev/null\n+++ door_controller/package.xml\n" in done.stdout
    assert list(tmp_path.iterdir()) == []


def test_patch_makes_what_generate_writes(robosc: Robosc, tmp_path: Path) -> None:
    """Changed, new and removed files; own lines and the end of a file without a line end."""
    model = tmp_path / "door.rscd"
    model.write_text(DOOR.read_text())
    assert robosc("generate", str(model)).returncode == 0
    package = tmp_path / "door_controller"
    before = tree(package)
    assert robosc("generate", str(model), "--diff").stdout == ""
    model.write_text(DOOR.read_text().replace("0.01", "0.02"))
    done = robosc("generate", str(model), "--diff", "--mode", "controller")
    assert done.returncode == 1
    assert "<= 0.02" in done.stdout
    assert tree(package) == before
    patched = subprocess.run(
        ["patch", "-p0"], cwd=tmp_path, input=done.stdout, text=True, capture_output=True
    )
    assert patched.returncode == 0, patched.stdout + patched.stderr
    by_patch = tree(package)
    for path, content in before.items():
        path.write_bytes(content)
    assert robosc("generate", str(model)).returncode == 0
    record = package / "generated.sha256"
    assert {**tree(package), record: b""} == {**by_patch, record: b""}
    assert robosc("generate", str(model), "--diff").returncode == 0


def test_what_generate_would_refuse(robosc: Robosc, tmp_path: Path) -> None:
    (tmp_path / "door_controller").mkdir()
    (tmp_path / "door_controller" / "package.xml").write_text("<package/>\n")
    done = robosc("generate", str(DOOR), "--diff")
    assert (done.returncode, done.stdout) == (2, "")
    assert "package.xml: not written by robosc" in done.stderr
