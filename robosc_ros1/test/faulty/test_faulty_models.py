"""Every diagnostic code has a model that shows it, with its exact output.

``./dev renew`` writes the outputs anew after a wanted change; read what ``git diff`` then shows.
"""

from __future__ import annotations

import re
from pathlib import Path

import pytest
from kept import Kept

from robosc.cli import main
from robosc.codes import CODES, Code
from robosc.errors import Severity, render_all
from robosc.model.resolve import load
from robosc.model.ros.definitions import MessageDefinitions

FOLDER = Path(__file__).parent
ABOUT_ROS_2 = ("refusal-not-seen",)
MODELS = sorted(p.stem for p in FOLDER.glob("*.rscd") if not p.stem.startswith("_"))


@pytest.mark.parametrize("code", MODELS)
def test_output_is_exact(code: str, kept: Kept, monkeypatch: pytest.MonkeyPatch) -> None:
    model = FOLDER / f"{code}.rscd"
    monkeypatch.chdir(FOLDER)
    environment = {"ROS_VERSION": "2"} if code in ABOUT_ROS_2 else {}
    definitions = MessageDefinitions.for_model(model, environment)
    robot, diagnostics = load(model.name, definitions=definitions)
    kept.text(FOLDER / f"{code}.txt", render_all(diagnostics))
    shown = [d for d in diagnostics if d.code == code]
    assert shown
    assert all(d.severity is CODES[code].severity for d in shown)
    assert (robot is None) == any(d.severity.value == "error" for d in diagnostics)


def test_every_code_about_text_and_model_has_a_faulty_model() -> None:
    # The codes of the plant have models in the tests of the synthesis, those of supervisors below.
    codes = [c for c in CODES.values() if not c.needs_plant and not c.supervised]
    assert [c.code for c in codes if c.code not in MODELS] == []


def test_every_faulty_model_shows_a_code_that_exists() -> None:
    assert [name for name in MODELS if name not in CODES] == []


PAGE = (FOLDER.parents[2] / "docs" / "diagnostics.md").read_text(encoding="utf-8")


def test_the_page_explains_every_code_by_an_example_and_a_remedy() -> None:
    assert codes_of_the_page() == CODES


def codes_of_the_page() -> dict[str, Code]:
    """What the page says of each code. It names none twice, and each section has all its parts."""
    found: dict[str, Code] = {}
    _, *chapters = PAGE.split("\n## ")
    for chapter in chapters:
        title, *sections = chapter.split("\n### ")
        for section in sections:
            parts = re.fullmatch(
                r"(?P<code>\S+)\n\n\*(?P<severity>\w+)\*(?P<strict>.*)\n\n"
                r"\S.*\n\n```\n(?:.*\n)+?```\n\n\S.*\n?",
                section,
            )
            assert parts and parts["code"] not in found, section
            assert parts["strict"] in ("", " (with `--strict` an error)")
            found[parts["code"]] = Code(
                parts["code"],
                Severity(parts["severity"]),
                strict=bool(parts["strict"]),
                needs_plant=title.startswith("The controlled system"),
                supervised=title.startswith("Supervisors that guard another controller"),
            )
    return found


SUPERVISED = sorted(p.stem for p in (FOLDER / "supervised").glob("*.rscd"))


def test_every_code_of_supervisors_has_a_faulty_model() -> None:
    assert sorted(c.code for c in CODES.values() if c.supervised) == SUPERVISED


@pytest.mark.parametrize("code", SUPERVISED)
def test_output_is_exact_when_one_mode_is_generated_and_the_other_works(
    code: str,
    kept: Kept,
    monkeypatch: pytest.MonkeyPatch,
    tmp_path: Path,
    capsys: pytest.CaptureFixture[str],
) -> None:
    monkeypatch.chdir(FOLDER / "supervised")
    arguments = ["generate", f"{code}.rscd", "--output", str(tmp_path), "--mode"]
    works, fails = "controller", "supervisor"
    if code == "data-of-others":
        works, fails = fails, works
    assert main([*arguments, works]) == 0
    capsys.readouterr()
    assert main([*arguments, fails]) == 1
    kept.text(FOLDER / "supervised" / f"{code}.txt", capsys.readouterr().err)
    assert [path.name for path in tmp_path.iterdir()] == [f"cart_{works}"]
