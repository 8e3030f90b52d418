"""The documents of verbs follow their schemas where there is something to tell.

That they do so for every mode and construct is in ``test_verbs_modes_constructs.py``.
"""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import models
import pytest
from runtime.schemas import FOLDER, validate

from robosc.cli import main

TEXTS = {
    name: text for name, text in vars(models).items() if name.isupper() and isinstance(text, str)
}


@pytest.fixture
def document(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> Any:
    """Runs a verb with a model; its document, which follows the schema of the verb, or None."""

    def printed(verb: str, text: str, *words: str, json_: str = "--json") -> Any:
        model = tmp_path / "model.rscd"
        model.write_text(text, encoding="utf-8")
        code = main([verb, str(model), *words, *json_.split()])
        out = capsys.readouterr().out
        assert out or code
        if not out:
            return None
        found = json.loads(out)
        validate(found, verb)
        return found

    return printed


@pytest.mark.parametrize("name", TEXTS)
def test_documents_follow_their_schemas(document: Any, name: str) -> None:
    assert document("check", TEXTS[name])["version"] == 1
    for verb in ("synthesize", "explore", "verify"):
        document(verb, TEXTS[name])
    document("explore", TEXTS[name], "--plant")
    document("export", TEXTS[name], json_="--format json")


def test_what_there_is_to_tell_is_in_them(document: Any) -> None:
    diagnostics = document("check", models.WITH_ERRORS)["diagnostics"]
    assert {d["severity"] for d in diagnostics} == {"error"}
    empty = document("synthesize", models.EMPTY_SUPERVISOR)
    assert empty["controlled_states"] == 0 and empty["explanations"][0]["event"] is None
    never = document("synthesize", models.NEVER)
    assert "never" in {guard["status"] for guard in never["guards"]}
    assert any(found["event"] for found in never["explanations"])
    assert document("export", models.EMPTY_SUPERVISOR, json_="--format json")["supervisor"]["empty"]


def test_a_departure_from_the_model_is_in_the_document(document: Any, tmp_path: Path) -> None:
    event = {"kind": "response", "name": "switch_light", "value": None}
    line = {"version": 1, "number": 1, "time": 1.0, "event": event, "outcome": "applied"}
    log = tmp_path / "run.jsonl"
    log.write_text(json.dumps({**line, "detail": None}) + "\n", encoding="utf-8")
    assert document("replay", models.GOOD, str(log))["departures"][0]["number"] == 1


def test_the_index_names_every_schema() -> None:
    index = (FOLDER.parent / "README.md").read_text(encoding="utf-8")
    assert [p.name for p in FOLDER.glob("*.json") if f"(schemas/{p.name})" not in index] == []


@pytest.mark.parametrize("path", sorted(FOLDER.glob("*.json")), ids=lambda path: path.name)
def test_schemas_refuse_what_they_do_not_describe(path: Path) -> None:
    """A schema that takes anything would test nothing."""
    jsonschema = pytest.importorskip("jsonschema")
    name = path.name.removesuffix(".schema.json")
    for document in (None, [], {"version": 2}, {"version": 1, "robots": []}):
        with pytest.raises(jsonschema.ValidationError):
            validate(document, name)
