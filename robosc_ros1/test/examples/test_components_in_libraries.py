"""A component does the same where it stands in a library: nothing changes but places."""

from __future__ import annotations

import ast
import re
import shutil
from pathlib import Path

import pytest
from emit.generated_code import controller_source
from ros_support import EXAMPLES
from syntax_support import parsed

from robosc import pipeline
from robosc.supervisor import Supervisor
from robosc.syntax.nodes import ComponentNode
from robosc.traces.coverage import Coverage
from robosc.traces.exact_steps import Steps

MOVED = (
    ("courier", "Base"), ("door", "Motor"), ("drone", "Autopilot"), ("kobuki", "Base"),
    ("navigation", "Navigator"), ("order", "Stop"), ("patrol", "Battery"),
)  # fmt: skip
PLACE = re.compile(r"\w+\.rscd:\d+|line \d+")


def supervised(path: Path) -> Supervisor:
    return pipeline.supervise(pipeline.load(path, pipeline.Options()).robot)


def cases(supervisor: Supervisor) -> list[str]:
    """What tests of its package are to show, as text."""
    return list(Coverage(Steps(supervisor)).cases.values())


def without_places(supervisor: Supervisor) -> tuple[str, list[str]]:
    code = PLACE.sub("", controller_source(supervisor, "robot.rscd"))
    return ast.unparse(ast.parse(code)), [PLACE.sub("", text) for text in cases(supervisor)]


@pytest.mark.parametrize(("example", "component"), MOVED)
def test_nothing_changes_but_places(
    example: str, component: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("ROS_PACKAGE_PATH", str(EXAMPLES))
    model = tmp_path / example / f"{example}.rscd"
    shutil.copytree(EXAMPLES / example, model.parent)
    text = model.read_text(encoding="utf-8")
    own = without_places(supervised(model))
    found = (d for d in parsed(text).declarations if isinstance(d, ComponentNode))
    (span,) = (c.span for c in found if c.name.text == component)
    library = f"library Parts {{\n{span.text}\n}}\n"
    (model.parent / "Parts.rscd").write_text(library, encoding="utf-8")
    imported = f"component {component} from Parts import {component}"
    model.write_text(text[: span.start] + imported + text[span.end :], encoding="utf-8")
    supervisor = supervised(model)
    assert without_places(supervisor) == own
    told = [text for text in cases(supervisor) if f" in {component} (" in text]
    assert told
    assert all(f" in {component} (Parts.rscd:" in text for text in told)
