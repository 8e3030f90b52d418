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
from robosc.model.resolve import load
from robosc.plant.build import lower
from robosc.source import Source
from robosc.synthesis import synthesize

FOLDER = Path(__file__).parent / "faulty"
MODELS = sorted(path.stem for path in FOLDER.glob("*.rscd"))


def shown(code: str) -> str:
    robot, found = load(f"{code}.rscd")
    assert robot is not None, render_all(found)
    if code == "synthesis-unchecked":
        diagnostics = pipeline.check(f"{code}.rscd").diagnostics
    else:
        time = 0 if code == "explanations-left-out" else None
        diagnostics = synthesize(lower(robot), "dense", explain_seconds=time).diagnostics
    assert [CODES[d.code].severity for d in diagnostics] == [d.severity for d in diagnostics]
    assert code in {d.code for d in diagnostics}
    return render_all(diagnostics)


@pytest.mark.parametrize("code", MODELS)
def test_output_is_exact(code: str, kept: Kept, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(FOLDER)
    kept.text(FOLDER / f"{code}.txt", shown(code))


def test_every_code_of_the_plant_has_a_faulty_model() -> None:
    assert sorted(c.code for c in CODES.values() if c.needs_plant) == MODELS


LAMPS = """
    component Bystander[1..14] {
        outgoing message bystanders_light with type: boolean
        incoming message bystanders_blink with type: none
        behaviour {
            initial marked state dark { on response from bystanders_light if value goto lit }
            marked state lit { on request to bystanders_blink goto dark }
        }
    }
}
"""
"""So many independent components that a model with them is solved in parts."""
NEVER_ASSIGNED = """robot Example {
    interface thing use Thing from some_robot_msgs
    datatype object Place { x: double }
    component Operator {
        outgoing message target with type: Place links thing
        behaviour { variable place: Place initial marked state s {} }
    }
    component Base {
        incoming message go with type: Place links thing
        behaviour { initial marked state a { on request to go goto b } marked state b {} }
    }
    provide go with Operator.place
}
"""
TEXTS = {
    **{
        c: (FOLDER / f"{c}.rscd").read_text()
        for c in MODELS
        if not c.endswith(("unchecked", "left-out"))
    },
    "nothing-to-send, never assigned": NEVER_ASSIGNED,
}


@pytest.mark.parametrize("engine", ["dense", "bdd"])
@pytest.mark.parametrize("code", TEXTS)
def test_each_code_is_reported_whether_solved_whole_or_in_parts(code: str, engine: str) -> None:
    text = TEXTS[code]

    def told(text: str) -> list[tuple[str, str, int, int]]:
        robot, found = load(Source("model.rscd", text))
        assert robot is not None, render_all(found)
        told = synthesize(lower(robot), engine).diagnostics
        return [(d.code, d.severity.value, d.span.line, d.span.column) for d in told]

    whole = told(text)
    assert code.partition(",")[0] in {code for code, *_ in whole}
    assert sorted(told(text.rstrip().removesuffix("}") + LAMPS)) == sorted(whole)
