"""``./dev mutants``: what it prints of a model, and of what is none."""

from __future__ import annotations

import sys
from pathlib import Path

import pytest
from emit import mutation_run

SWITCH = """
robot Switch {
    component Lamp {
        incoming message shine with identifier: "/shine", type: none
        outgoing message dark with identifier: "/dark", type: boolean
        behaviour {
            initial marked state off { on response from dark if value goto on }
            marked state on { on response from dark if !value goto off }
        }
    }
    requirement shine needs Lamp.on
}
"""


def run(monkeypatch: pytest.MonkeyPatch, model: Path) -> int:
    monkeypatch.setattr(sys, "argv", ["mutants", str(model)])
    return mutation_run.run()


def test_rows_tell_how_many_are_found(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    model = tmp_path / "switch.rscd"
    model.write_text(SWITCH)
    assert run(monkeypatch, model) == 0
    rows = [line for line in capsys.readouterr().out.splitlines()[2:] if line.startswith("|")]
    for mode, row in zip(("controller", "supervisor"), rows, strict=True):
        name, guards, data, rules, _, _, undecided, missed, _ = row.strip("| ").split(" | ")
        assert (name, guards, data, rules) == (f"switch, {mode}", "1/1", "0/0", "0/0")
        assert (undecided, missed) == ("0", "0")


def test_a_supervisor_that_cannot_tell_commands_apart_is_passed_over(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    model = tmp_path / "switch.rscd"
    both = 'incoming message glow with identifier: "/shine", type: none\n        outgoing'
    model.write_text(SWITCH.replace("outgoing", both))
    assert run(monkeypatch, model) == 0
    lines = capsys.readouterr().out.splitlines()
    assert lines[2].startswith("| switch, controller |")
    assert lines[-1] == "| switch, supervisor | its commands cannot be told apart |"


LIMITER = """
robot Limiter {
    component Base {
        incoming message move with identifier: "/move", type: integer(0..9)
        outgoing message most with identifier: "/most", type: integer(0..9)
        behaviour {
            variable least: integer(0..9) = 3
            initial marked state on { on response from most do least := value }
        }
    }
    provide move with min(value, 5) if value > Base.least
    requirement move needs value >= Base.least
}
"""


def test_supervisors_are_compared_by_what_they_make_of_data(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    model = tmp_path / "limiter.rscd"
    model.write_text(LIMITER)
    assert run(monkeypatch, model) == 0
    lines = capsys.readouterr().out.splitlines()
    assert lines[2] == "| limiter, controller | it corrects another controller |"
    assert lines[3].startswith("| limiter, supervisor | 2/2 | 0/0 | 4/10 | 1/1 | 6 | 0 | 0 |")
    unfound = [line for line in lines[4:] if "=>" in line]
    assert all("in_range(message.data, 0, 9" in line for line in unfound), "ROS has these fields"


def test_errors_of_a_model_are_told(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    model = tmp_path / "faulty.rscd"
    assert run(monkeypatch, model) == 2
    assert "cannot read" in capsys.readouterr().err
    model.write_text(SWITCH.replace("needs Lamp.on", "needs Lamp.bright"))
    assert run(monkeypatch, model) == 1
    assert "error[" in capsys.readouterr().err
