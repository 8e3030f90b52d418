"""``import robosc``: from texts as from files, with the documents of the commands, and pictures."""

from __future__ import annotations

import importlib
import json
import shutil
from pathlib import Path

import pytest
from models import EMPTY_SUPERVISOR, GOOD, WITH_ERRORS

import robosc
from robosc.cli import main


@pytest.fixture
def path(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.chdir(tmp_path)
    file = Path("lamp.rscd")
    file.write_text(GOOD, encoding="utf-8")
    return file


def test_documents_are_those_of_the_commands(
    path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    supervisor = robosc.synthesize(path)
    results = {
        "check": robosc.check(path),
        "synthesize": supervisor,
        "explore": robosc.explore(supervisor),
        "verify": robosc.verify(supervisor),
    }
    for verb, result in results.items():
        assert main([verb, str(path), "--json"]) == 0
        printed = json.loads(capsys.readouterr().out)
        assert result.document() | {"seconds": 0} == printed | {"seconds": 0}


@pytest.mark.parametrize("plant", [False, True])
def test_a_text_is_what_its_file_would_be(path: Path, plant: bool) -> None:
    text = robosc.ModelText(GOOD.replace("\n", "\r\n"), path)
    given = (path, str(path), text, robosc.load(text), robosc.synthesize(text))
    first, *others = [robosc.explore(one, plant=plant).document() for one in given]
    assert all(other == first for other in others)


def test_packages_from_a_text_are_those_from_its_file(path: Path) -> None:
    def package(model: Path | robosc.ModelText, folder: str) -> dict[str, bytes]:
        made = robosc.generate(model, output=robosc.Output(folder=Path(folder))).files.folder
        files = [file for file in made.rglob("*") if file.is_file()]
        return {str(file.relative_to(made)): file.read_bytes() for file in files}

    assert package(path, "one") == package(robosc.ModelText(GOOD, path), "two") != {}


def test_libraries_are_searched_for_around_the_file_of_a_text(tmp_path: Path) -> None:
    library = "library Parts { component Eye { outgoing message seen with type: none } }"
    (tmp_path / "parts.rscd").write_text(library, encoding="utf-8")
    text = "robot R { component Eye from Parts import Eye }"
    assert robosc.load(robosc.ModelText(text, tmp_path / "r.rscd")).components == ("Eye",)
    (tmp_path / "below").mkdir()
    with pytest.raises(robosc.ModelError, match="library-not-found"):
        robosc.load(robosc.ModelText(text, tmp_path / "below" / "r.rscd"))


@pytest.mark.parametrize("text", [GOOD, "robot R {}", "x" * 5000 + "\n", "robot\0{"])
def test_a_text_without_its_name_is_told(text: str) -> None:
    with pytest.raises(robosc.UsageError, match=r"robosc\.ModelText"):
        robosc.check(text)


def test_faults_are_raised_with_places(tmp_path: Path) -> None:
    with pytest.raises(robosc.ModelError, match=r"lamp\.rscd:5:\d+: error\[unknown-"):
        robosc.synthesize(robosc.ModelText(WITH_ERRORS, "lamp.rscd"))
    with pytest.raises(robosc.ModelError, match="invalid-utf8"):
        robosc.load(robosc.ModelText("robot R \udc80 {}"))
    with pytest.raises(robosc.UsageError, match="cannot read"):
        robosc.load(tmp_path / "nothing.rscd")
    with pytest.raises(robosc.UsageError, match="holds a library"):
        robosc.load(robosc.ModelText("library L {}"))
    with pytest.raises(TypeError, match=r"robosc\.ModelText"):
        robosc.load(7)  # type: ignore[arg-type]


def test_an_empty_supervisor_is_a_result_and_nothing_to_go_on_with() -> None:
    found = robosc.synthesize(robosc.ModelText(EMPTY_SUPERVISOR))
    assert found.empty and found.explanations and not found.states
    assert "Alarm" in found._repr_html_()
    assert not robosc.check(robosc.ModelText(EMPTY_SUPERVISOR)).ok
    for further in (robosc.verify, robosc.explore, robosc.simulate):
        with pytest.raises(robosc.EmptySupervisorError):
            further(found)


@pytest.mark.skipif(shutil.which("dot") is None, reason="needs graphviz")
def test_robots_and_supervisors_are_drawn(path: Path) -> None:
    robot = robosc.load(path)
    assert robot._repr_html_().startswith("<svg") and "switch_light" in robot.svg()
    assert "controlled system" not in robot.svg()
    assert "controlled system: 16 states" in robosc.synthesize(robot).svg()


def test_without_graphviz_there_is_the_text(path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("PATH", "")
    found = robosc.synthesize(path)
    assert "<pre>Lamp: 16 of" in found._repr_html_() and "graphviz" in found._repr_html_()
    with pytest.raises(robosc.UsageError, match="graphviz"):
        found.svg()


def test_the_function_simulate_stays_when_the_subpackage_is_imported(path: Path) -> None:
    importlib.reload(importlib.import_module("robosc.simulate"))
    played = robosc.simulate(path)
    assert played.do("dark true").happened[0]["event"]["value"] is True
    assert played.state["variables"]["Bulb.is_dark"] is True
    assert "switch_light.request" not in played.blocked
    with pytest.raises(robosc.LineFault) as fault:
        played.do("expect Bulb.busy")
    assert fault.value.kind == "failed"
    assert "Bulb" in played._repr_html_()
    with pytest.raises(robosc.LineFault, match="unknown parameter"):
        robosc.simulate(path, execute=True, parameters={"rates": 3})


def test_results_are_short_where_python_shows_them(path: Path) -> None:
    supervisor = robosc.synthesize(path)
    written = robosc.generate(path, output=robosc.Output(folder=Path("out")))
    results = (
        robosc.load(path), supervisor, robosc.check(path), robosc.verify(supervisor),
        robosc.explore(supervisor), robosc.simulate(supervisor), written,
    )  # fmt: skip
    shown = [repr(result) for result in results]
    assert all(len(text) < 200 and "\n" not in text for text in shown), shown
    assert shown[0] == "<LoadedRobot: Lamp: Bulb>"


def test_wrong_words_are_told(path: Path) -> None:
    wrong = (
        lambda: robosc.synthesize(path, engine="fast"),
        lambda: robosc.export(path, "png"),  # type: ignore[arg-type]
        lambda: robosc.generate(path, output=robosc.Output("ros3")),  # type: ignore[arg-type]
        lambda: robosc.generate(path, output=robosc.Output(mode="spy")),  # type: ignore[arg-type]
    )
    for call in wrong:
        with pytest.raises(robosc.UsageError, match="there are"):
            call()
    assert not list(path.parent.glob("*_controller"))


def test_folders_may_be_texts(path: Path) -> None:
    Path("own.yaml").write_text("package: lamps\n", encoding="utf-8")
    output = robosc.Output(folder="out", config="own.yaml")  # type: ignore[arg-type]
    assert robosc.generate(path, output=output).package == "lamps"
    assert Path("out", "lamps", "package.xml").is_file()
