"""Nothing fails on text that is broken, whichever way."""

from __future__ import annotations

import random
from pathlib import Path

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from lsp_support import open_text
from ros_support import EXAMPLES

from robosc.lsp.actions import actions_for
from robosc.lsp.analysis import Workspace
from robosc.lsp.completion.complete import complete
from robosc.lsp.hover import definition_of, hover_text
from robosc.lsp.outline import folds, outline
from robosc.lsp.rename import applied, references
from robosc.lsp.semantic_tokens import TYPES, encoded

pytestmark = pytest.mark.slow

PATH = str(EXAMPLES / "line_follower_first_edition" / "line_follower.rscd")
TEXT = Path(PATH).read_text(encoding="utf-8")
_INSERTED = (
    "{",
    "}",
    '"',
    "'",
    "/*",
    "//",
    "🤖",
    ".",
    "on ",
    "robot ",
    "^",
    "\t",
    "value.",
    ":=",
    "(",
)


def everything(workspace: Workspace, text: str, offset: int) -> None:
    """What an editor may ask for at a place; the answers hang together."""
    analysis = open_text(workspace, PATH, text)
    complete(workspace, PATH, offset)
    data = encoded(analysis)
    assert len(data) % 5 == 0 and all(number >= 0 for number in data)
    assert all(kind < len(TYPES) for kind in data[3::5])
    for entry in outline(analysis):
        assert entry.whole.start <= entry.name.start <= entry.name.end <= entry.whole.end
    for fold in folds(analysis.source):
        assert 1 <= fold.first < fold.last
    for diagnostic in analysis.diagnostics:
        for action in actions_for(analysis, diagnostic):
            applied(analysis.source, list(action.edits))
    here = analysis.index.at(offset)
    for occurrence in (*analysis.index.occurrences[-2:], *([here] if here else [])):
        hover_text(analysis, occurrence, None)
        definition_of(analysis, occurrence)
        found = [
            o for here in references(workspace, PATH, occurrence.symbol).values() for o in here
        ]
        assert occurrence in found


def test_typing_at_the_end() -> None:
    workspace = Workspace()
    for end in range(0, len(TEXT) + 1, 8):
        everything(workspace, TEXT[:end], end)


def test_typing_in_the_middle() -> None:
    """What stands behind the cursor is whole."""
    workspace = Workspace()
    start, end = TEXT.index("service set_light_state"), TEXT.index("// What must hold")
    for place in range(start, end, 4):
        everything(workspace, TEXT[:place] + TEXT[end:], place)


def test_random_edits() -> None:
    chance = random.Random(7)
    workspace = Workspace()
    text = TEXT
    for step in range(150):
        if step % 15 == 0:
            text = TEXT
        place = chance.randrange(len(text) + 1)
        if chance.random() < 0.5:
            text = text[:place] + text[place + chance.randrange(1, 30) :]
        else:
            text = text[:place] + chance.choice(_INSERTED) + text[place:]
        everything(workspace, text, min(place, len(text)))


@settings(max_examples=150)
@given(
    st.lists(
        st.sampled_from(
            ("robot", "library", "{", "}", "component", "requirement", "provide", "with", "on",
             "response", "from", "if", "do", ":=", "goto", "a", "value", ".", ":", "->", "default",
             "datatype", "enum", "object", "needs", "=", "[", "]", "(", ",", "interface", "use",
             "import", "state", "behaviour", "variable", "and", "links", "message", "\n", '"'),
        ),
        max_size=30,
    )
)  # fmt: skip
def test_any_words(words: list[str]) -> None:
    text = " ".join(words)
    everything(Workspace(), text, len(text))
    everything(Workspace(), "robot R { " + text, len(text) + 10)
