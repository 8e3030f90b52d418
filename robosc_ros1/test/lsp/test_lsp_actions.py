"""Code actions do what the hints say, and the fault is gone."""

from __future__ import annotations

import shutil
from pathlib import Path

import pytest
from lsp_support import open_text
from ros_support import EXAMPLES

from robosc import pipeline
from robosc.lsp.actions import actions_for
from robosc.lsp.analysis import Analysis, Workspace
from robosc.lsp.rename import applied

FAULTY = Path(__file__).parents[1] / "faulty"
MODELS = sorted(f for f in FAULTY.glob("*.rscd") if not f.name.startswith("_"))


def analysed(file: Path) -> Analysis | None:
    return Workspace().analysis(str(file))


def faults(analysis: Analysis) -> list[tuple[str, str]]:
    return [(d.code, d.message) for d in analysis.diagnostics]


@pytest.mark.parametrize("file", MODELS, ids=lambda file: file.stem)
def test_action_mends(file: Path) -> None:
    """Each action that is offered for a faulty model ends the fault, and breaks nothing else."""
    analysis = analysed(file)
    if analysis is None:  # no UTF-8
        return
    for diagnostic in analysis.diagnostics:
        for action in actions_for(analysis, diagnostic):
            text = applied(analysis.source, list(action.edits))
            after = open_text(Workspace(), file, text)
            told = (diagnostic.code, diagnostic.message)
            assert faults(after).count(told) < faults(analysis).count(told), action.title
            # A fault can hide others, but what is written must be read.
            unreadable = [c for c, _ in faults(after) if c in ("syntax", "missing-brace")]
            before = [c for c, _ in faults(analysis) if c in ("syntax", "missing-brace")]
            assert len(unreadable) <= len(before), action.title


EXPECTED = {
    "ambiguous-name": "Write 'Speed.fast'",
    "empty-range": "Write 'integer(1..5)'",
    "import-incomplete": "Add 'component Hand from Arms import Hand with prefix: \"/left\"'",
    "missing-default": "Add 'default -> free'",
    "missing-links": "Link 'speed'",
    "no-initial-state": "Add an initial state",
    "reserved-name": "Write '^value'",
    "several-defaults": "Remove 'default -> obstructed'",
    "stale-data": "Add a timeout and 'requirement drive needs free.fresh'",
    "several-initial-states": "Remove 'initial' from 'cold'",
    "unknown-communication": "Write 'move'",
    "unknown-member": "Write 'current'",
    "unknown-type": "Write 'Distance'",
    "unterminated-comment": "Close it with */",
    "unterminated-string": 'Close it with "',
}


@pytest.mark.parametrize("code", EXPECTED)
def test_action_is_offered(code: str) -> None:
    analysis = analysed(FAULTY / f"{code}.rscd")
    assert analysis is not None
    titles = [a.title for d in analysis.diagnostics for a in actions_for(analysis, d)]
    assert EXPECTED[code] in titles


def test_missing_links_take_an_interface_that_is_declared() -> None:
    text = """robot Example {
    component Motor {
        incoming message move with type: Velocity
        outgoing message speed with type: Fast
        service reset with request: none, response: none
        action home with request: Mode, response: none, feedback: none
    }
    datatype object Velocity { x: double }
    datatype enum Fast from Velocity to { value.x > 3 -> fast default -> slow }
    datatype object Mode { hard: boolean }
    interface turn use Turn from example_msgs
    interface vel use Speed from example_msgs
    interface again use Reset from example_msgs
}
"""
    file = FAULTY / "model.rscd"
    analysis = open_text(Workspace(), file, text)
    missing = [d for d in analysis.diagnostics if d.code == "missing-links"]
    found = {d.span.text: actions_for(analysis, d) for d in missing}
    titles = {marked: [action.title for action in actions] for marked, actions in found.items()}
    assert titles == {
        "Velocity": ["Link 'vel'"], "Fast": ["Link 'vel'"], "reset": ["Link 'again'"], "home": [],
    }  # fmt: skip
    edits = [edit for actions in found.values() for action in actions for edit in action.edits]
    mended = applied(analysis.source, edits)
    assert "response: none links again\n" in mended
    after = open_text(Workspace(), file, mended)
    assert [d.span.text for d in after.diagnostics if d.code == "missing-links"] == ["home"]


def test_freshness_takes_two_edits(tmp_path: Path) -> None:
    file = tmp_path / "model.rscd"
    text = (
        "robot R {\n"
        "    component Eye {\n"
        '        outgoing message scan with identifier: "/scan", type: boolean\n'
        "        behaviour { variable free: boolean\n"
        "            initial marked state on { on response from scan do free := value } }\n"
        "    }\n"
        "    component Base { incoming message go with type: none incoming message halt with type: none }\n"
        "    requirement go needs Eye.free\n"
        "    requirement halt needs !Eye.free\n"
        "}\n"
    )
    analysis = open_text(Workspace(), file, text)
    (diagnostic,) = (d for d in analysis.diagnostics if d.code == "stale-data")
    first, second = actions_for(analysis, diagnostic)
    assert second.title == "Add a timeout and 'requirement halt needs scan.fresh'"
    mended = applied(analysis.source, list(first.edits))
    assert mended == text.replace("type: boolean\n", "timeout: 500 ms, type: boolean\n", 1).replace(
        "    requirement go needs Eye.free",
        "    requirement go needs scan.fresh\n    requirement go needs Eye.free",
    )
    assert not open_text(Workspace(), file, mended).diagnostics


def test_freshness_of_one_of_several(tmp_path: Path) -> None:
    """Each edit names a copy where several have the message."""
    text = (
        "robot R {\n"
        "    component Eye[1..2] {\n"
        '        outgoing message shut with identifier: "/shut{index}", type: boolean\n'
        "        behaviour { initial marked state on { on response from shut if value goto off }\n"
        "            marked state off { on response from shut if !value goto on } }\n"
        "    }\n"
        "    component Base { incoming message go with type: none }\n"
        "    requirement go needs all(e.on for e in Eye)\n"
        "    stop with nothing\n"
        "}\n"
    )
    analysis = open_text(Workspace(), tmp_path / "model.rscd", text)
    (diagnostic,) = (d for d in analysis.diagnostics if d.code == "stale-event")
    (action,) = actions_for(analysis, diagnostic)
    assert action.title == "Add a timeout and 'requirement go needs Eye[1].shut.fresh'"
    mended = applied(analysis.source, list(action.edits))
    assert not open_text(Workspace(), tmp_path / "model.rscd", mended).diagnostics
    unused = mended.replace("    requirement go needs Eye[1].shut.fresh\n", "")
    (diagnostic,) = open_text(Workspace(), tmp_path / "model.rscd", unused).diagnostics
    assert str(diagnostic.hint) == (
        "add 'requirement COMMAND needs Eye[1].shut.fresh', or react to it:"
        " 'on timeout from shut goto STATE'"
    )


def test_a_message_that_is_to_be_fresh_takes_a_timeout(tmp_path: Path) -> None:
    file = tmp_path / "model.rscd"
    text = (
        "robot R {\n"
        "    component Eye { outgoing message scan with type: none }\n"
        "    component Base { incoming message go with type: none }\n"
        "    requirement go needs scan.fresh\n"
        "}\n"
    )
    analysis = open_text(Workspace(), file, text)
    (diagnostic,) = analysis.diagnostics
    (action,) = actions_for(analysis, diagnostic)
    assert action.title == "Add 'timeout: 500 ms,' to scan"
    mended = applied(analysis.source, list(action.edits))
    assert mended == text.replace("type: none", "timeout: 500 ms, type: none", 1)
    assert not open_text(Workspace(), file, mended).diagnostics


def test_remedy_of_synthesis(tmp_path: Path) -> None:
    """The example that forgets errors is mended by the actions alone."""
    file = tmp_path / "model.rscd"
    shutil.copy(EXAMPLES / "line_follower_unhandled" / "line_follower_unhandled.rscd", file)
    for _ in range(5):
        analysis = analysed(file)
        assert analysis is not None and analysis.reading.robot is not None
        supervisor = pipeline.synthesize(analysis.reading.robot)
        actions = [a for d in supervisor.diagnostics for a in actions_for(analysis, d)]
        if not actions:
            break
        file.write_text(applied(analysis.source, list(actions[0].edits)))
    assert "on error from grab" in file.read_text()
    assert "never-allowed" not in {d.code for d in supervisor.diagnostics}


def test_actions_in_one_of_several_components(tmp_path: Path) -> None:
    """They change the declaration that all copies come from."""
    file = tmp_path / "model.rscd"
    text = (
        "robot R {\n"
        "    component Station[1..2] {\n"
        "        incoming message go with type: none\n"
        "        behaviour {\n            state free {}\n        }\n"
        "    }\n"
        "}\n"
    )
    analysis = open_text(Workspace(), file, text)
    (diagnostic,) = (d for d in analysis.diagnostics if d.code == "no-initial-state")
    (action,) = actions_for(analysis, diagnostic)
    mended = applied(analysis.source, list(action.edits))
    assert mended == text.replace("state free", "initial state free")
