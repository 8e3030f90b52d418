"""What a place is part of is the same whether all of the text is read or only what has changed."""

from __future__ import annotations

import random

import pytest
from test_lsp_completion import MODEL

from robosc.lsp.completion.context import Landmarks, context_at
from robosc.source import Source

PIECES = ("{", "}", '"', "/*", "*/", "// x\n", "component A {", "requirement ", ".", "robot R {")


@pytest.mark.parametrize("seed", range(20))
def test_landmarks_change_nothing(seed: int) -> None:
    source = random.Random(seed)
    landmarks = Landmarks()
    text = MODEL
    for _ in range(60):
        place = source.randrange(len(text) + 1)
        end = min(len(text), place + source.choice((0, 0, 1, 20)))
        text = text[:place] + source.choice(PIECES) + text[end:]
        offset = source.randrange(len(text) + 1)
        model = Source("model.rscd", text)
        assert context_at(model, offset, landmarks) == context_at(model, offset)


def test_only_the_last_declaration_is_read_again() -> None:
    landmarks = Landmarks()
    offset = MODEL.index("Eye.open")
    context_at(Source("model.rscd", MODEL), offset, landmarks)
    changed = MODEL.replace("Eye.open", "Eye.shut")
    begin, blocks = landmarks.last(changed, offset)
    assert MODEL[:begin].endswith("links turn\n    }")
    assert [block.kind for block in blocks] == ["file", "robot"]
