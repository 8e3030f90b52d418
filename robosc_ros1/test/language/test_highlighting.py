"""The grammar that editors colour models by has the keywords of the table."""

from __future__ import annotations

import json
from pathlib import Path

from kept import Kept
from language.highlighting import with_keywords

from robosc.language.keywords import KEYWORDS

GRAMMAR = Path(__file__).parents[3] / "editors" / "vscode" / "syntaxes" / "rscd.tmLanguage.json"


def test_the_grammar_of_editors_is_made_from_the_table(kept: Kept) -> None:
    grammar = with_keywords(json.loads(GRAMMAR.read_text(encoding="utf-8")))
    kept.text(GRAMMAR, json.dumps(grammar, indent=2) + "\n")


def test_it_has_every_keyword() -> None:
    text = GRAMMAR.read_text(encoding="utf-8")
    assert [word for word in KEYWORDS if word not in text] == []
