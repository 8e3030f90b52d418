"""What synthesis finds, asked of a process of its own, and where that stands after a change."""

from __future__ import annotations

import json
import subprocess
from collections.abc import Iterable
from functools import cache
from pathlib import Path

import pytest
from lsp_support import open_text
from ros_support import EXAMPLES

from robosc import limits, pipeline
from robosc.errors import Diagnostic
from robosc.lsp.analysis import Workspace
from robosc.lsp.synthesis_process import Derived, answer, command, derived_from, moved, request_for
from robosc.source import Source

MODEL = EXAMPLES / "line_follower_unhandled" / "line_follower_unhandled.rscd"
TEXT = MODEL.read_text(encoding="utf-8")
SOURCE = Source(str(MODEL), TEXT)


@cache
def asked(source: Source) -> Derived:
    done = subprocess.run(
        command(), input=request_for(source, [], {}), capture_output=True, timeout=600
    )
    found = derived_from(source, done.stdout)
    assert found is not None, done.stderr.decode()
    return found


def test_answer_is_what_check_says() -> None:
    found = asked(SOURCE)
    robot = open_text(Workspace(), MODEL, TEXT).reading.robot
    assert robot is not None
    supervisor = pipeline.synthesize(robot)
    assert [(d.code, d.message, d.span.start, d.hint) for d in found.diagnostics] == [
        (d.code, d.message, d.span.start, d.hint) for d in supervisor.diagnostics
    ]
    grab = next(g for g in found.guards if g.communication.endswith(".grab"))
    assert grab.status == "never" and "on error from grab" in str(grab.reasons[0][1])


FAULTY = Path(__file__).parents[1] / "faulty"
MODELS = sorted(f for f in FAULTY.glob("*.rscd") if not f.name.startswith("_"))


@pytest.mark.parametrize("file", [MODEL, *MODELS], ids=lambda file: file.stem)
def test_the_editor_says_what_check_says(file: Path) -> None:
    """Each faulty model, synthesis included."""
    analysis = Workspace().analysis(str(file))
    if analysis is None:  # no UTF-8: no editor would show it
        return
    found = derived_from(
        analysis.source, json.dumps(answer(json.loads(request_for(analysis.source, [], {}))))
    )
    assert found is not None
    checked = pipeline.check(file)
    assert spoken([*analysis.diagnostics, *found.diagnostics]) == spoken(checked.diagnostics)


def spoken(diagnostics: Iterable[Diagnostic]) -> list[tuple[object, ...]]:
    return sorted(
        (
            d.span.source.path,
            d.span.start,
            d.span.end,
            d.severity.value,
            d.code,
            d.message,
            d.hint or "",
        )
        for d in diagnostics
    )


def test_broken_models_have_no_answer() -> None:
    assert asked(Source(str(MODEL), TEXT[:500])).diagnostics == ()


def test_synthesis_that_is_left_out_is_told(monkeypatch: pytest.MonkeyPatch) -> None:
    """In the words of ``check``."""
    monkeypatch.setattr(limits, "CHECK_SECONDS", 0.0)
    source = Source(str(MODEL), TEXT)
    found = derived_from(source, json.dumps(answer(json.loads(request_for(source, [], {})))))
    assert found is not None
    (warning,) = found.diagnostics
    assert (warning.code, warning.span.text) == ("synthesis-unchecked", "LineFollower")
    assert spoken([warning])[0] in spoken(pipeline.check(MODEL).diagnostics)


def test_no_answer_from_a_process_that_failed() -> None:
    assert derived_from(Source("x", ""), b"Traceback") is None


def test_diagnostics_move_with_the_text() -> None:
    found = asked(SOURCE)
    (first, *_) = found.diagnostics
    longer = Source(str(MODEL), "// one line more\n" + TEXT)
    assert moved(found, longer)[0].span.line == first.span.line + 1
    changed = TEXT[: first.span.start + 1] + "x" + TEXT[first.span.start + 1 :]
    assert first.code not in {d.code for d in moved(found, Source(str(MODEL), changed))}


def test_command_finds_robosc_by_itself(tmp_path: Path) -> None:
    done = subprocess.run(
        command(), input=b"", capture_output=True, cwd=tmp_path, env={}, timeout=600
    )
    assert b"No module named 'robosc'" not in done.stderr
