"""``check`` of folders, and its formats for continuous integration."""

from __future__ import annotations

import json
from collections.abc import Callable
from pathlib import Path

import pytest
from ros_support import Completed

Robosc = Callable[..., Completed]

FAULTY = """robot R {
    component C { incoming message m with type: none }
    requirement m needs C.x
}
"""


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    (tmp_path / "models" / "deep").mkdir(parents=True)
    (tmp_path / "models" / "good.rscd").write_text("robot G { component C {} }\n")
    (tmp_path / "models" / "deep" / "a b,c.rscd").write_text(FAULTY)
    return tmp_path


def test_folder(robosc: Robosc, folder: Path) -> None:
    done = robosc("check", "models")
    assert (done.returncode, done.stdout.split(",")[0]) == (1, "2 files: 1 error")
    assert "models/deep/a b,c.rscd:3:27: error[unknown-member]" in done.stderr


def test_folder_without_models(robosc: Robosc, tmp_path: Path) -> None:
    (tmp_path / "empty").mkdir()
    done = robosc("check", "empty")
    assert (done.returncode, done.stderr) == (2, "error: there is no .rscd file in empty\n")


def test_github(robosc: Robosc, folder: Path) -> None:
    done = robosc("check", "--format", "github", "models")
    assert done.returncode == 1
    assert done.stderr == ""
    (line,) = [each for each in done.stdout.splitlines() if each.startswith("::error ")]
    place = "file=models/deep/a b%2Cc.rscd,line=3,col=27,endLine=3,endColumn=28"
    assert line.startswith(f"::error {place},title=unknown-member::")
    assert all(each.startswith(("::error ", "::warning ")) for each in done.stdout.splitlines())


def test_sarif(robosc: Robosc, folder: Path) -> None:
    done = robosc("check", "--format", "sarif", "models")
    assert (done.returncode, done.stderr) == (1, "")
    document = json.loads(done.stdout)
    (run,) = document["runs"]
    assert (document["version"], run["tool"]["driver"]["name"]) == ("2.1.0", "robosc")
    (fault,) = [r for r in run["results"] if r["level"] == "error"]
    place = fault["locations"][0]["physicalLocation"]
    assert fault["ruleId"] == "unknown-member"
    assert place["artifactLocation"]["uri"] == "models/deep/a%20b%2Cc.rscd"
    assert place["region"] == {"startLine": 3, "startColumn": 27, "endLine": 3, "endColumn": 28}
    assert {"id": "unknown-member"} in run["tool"]["driver"]["rules"]


def test_json_by_either_option(robosc: Robosc, folder: Path) -> None:
    by_format = robosc("check", "--format", "json", "models")
    assert by_format.stdout == robosc("check", "--json", "models").stdout
