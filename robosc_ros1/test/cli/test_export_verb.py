"""``robosc export``: to standard output or a file, and what it says when that cannot be."""

from __future__ import annotations

import json
from collections.abc import Callable
from pathlib import Path

import models
import pytest
from ros_support import Completed

Robosc = Callable[..., Completed]


@pytest.fixture
def model(tmp_path: Path) -> str:
    (tmp_path / "good.rscd").write_text(models.GOOD, encoding="utf-8")
    return "good.rscd"


@pytest.mark.parametrize(
    ("format_", "start"), [("cif", "// "), ("dot", "digraph "), ("json", "{\n")]
)
def test_each_format_goes_to_standard_output(
    robosc: Robosc, model: str, format_: str, start: str
) -> None:
    done = robosc("export", model, "--format", format_)
    assert done.returncode == 0
    assert done.stdout.startswith(start)


def test_file_gets_the_same_as_standard_output(robosc: Robosc, model: str, tmp_path: Path) -> None:
    done = robosc("export", model, "--format", "json", "--output", "out.json")
    assert (done.returncode, done.stdout) == (0, "")
    written = (tmp_path / "out.json").read_text(encoding="utf-8")
    assert written == robosc("export", model, "--format", "json").stdout
    assert json.loads(written)["version"] == 1


def test_supervisor_is_added_to_cif(robosc: Robosc, model: str) -> None:
    assert "supervisor automaton" not in robosc("export", model, "--format", "cif").stdout
    done = robosc("export", model, "--format", "cif", "--supervisor")
    assert "supervisor automaton Supervisor:" in done.stdout


def test_unwritable_file_is_wrong_usage(robosc: Robosc, model: str) -> None:
    done = robosc("export", model, "--format", "cif", "--output", "missing/out.cif")
    assert (done.returncode, done.stdout) == (2, "")
    assert done.stderr == "error: cannot write missing/out.cif: No such file or directory\n"
