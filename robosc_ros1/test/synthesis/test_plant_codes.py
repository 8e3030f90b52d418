"""Every diagnostic that needs the state space has a model that shows it, with its exact output.

``./dev renew`` writes the outputs anew after a wanted change; read what ``git diff`` then shows.
"""

from __future__ import annotations

from pathlib import Path

import pytest
from kept import Kept

from robosc import pipeline
from robosc.codes import CODES
from robosc.errors import render_all
from robosc.ir.lower import lower
from robosc.model.resolve import load
from robosc.synthesis import synthesize

FOLDER = Path(__file__).parent / "faulty"
MODELS = sorted(path.stem for path in FOLDER.glob("*.rscd"))


def shown(code: str) -> str:
    robot, found = load(f"{code}.rscd")
    assert robot is not None, render_all(found)
    if code == "synthesis-unchecked":
        diagnostics = pipeline.check(f"{code}.rscd").diagnostics
    else:
        diagnostics = synthesize(lower(robot), "dense").diagnostics
    assert [CODES[d.code].severity for d in diagnostics] == [d.severity for d in diagnostics]
    assert code in {d.code for d in diagnostics}
    return render_all(diagnostics)


@pytest.mark.parametrize("code", MODELS)
def test_output_is_exact(code: str, kept: Kept, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(FOLDER)
    kept.text(FOLDER / f"{code}.txt", shown(code))


def test_every_code_of_the_plant_has_a_faulty_model() -> None:
    assert sorted(c.code for c in CODES.values() if c.needs_plant) == MODELS
