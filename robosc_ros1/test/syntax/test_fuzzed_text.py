"""No text whatsoever makes the parser fail: it answers with a tree, diagnostics or both."""

from __future__ import annotations

import re
from pathlib import Path

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from large_model import large_model

from robosc.errors import Diagnostic, has_errors, render_all
from robosc.source import Source
from robosc.syntax.nodes import FileNode
from robosc.syntax.parser import parse

pytestmark = pytest.mark.slow

EXAMPLE = (
    Path(__file__).parents[3] / "examples" / "line_follower_first_edition" / "line_follower.rscd"
)
MODELS = [EXAMPLE.read_text(), large_model(4)]

_WORDS = r"""
    robot library component requirement provide datatype interface object enum from to use import
    with prefix: incoming outgoing message service action identifier: type: request: response:
    feedback: links behaviour variable state initial marked transition on request response if do
    goto needs disables never always default string integer array none value true false and or
    constant parameter condition prefer over for in after timeout: ms s min any(
    { } ( ) [ ] , . .. : := = == => -> != < <= > >= + - * / ! ^ ^a a b A.b 0 1 007 1.5 1e 1e9 9.9.9
    99999999999999999999999 1e999 " ' "s" 's' "\q" // /* */ # ; & && | @ $ é \
"""
TOKENS = [*_WORDS.split(), "\0", "\ufeff", "\ud800", "\n", "\r\n", "\t", "\u2028", "\u00a0"]


def check(text: str) -> tuple[FileNode | None, tuple[Diagnostic, ...]]:
    """Parse; whatever is found must be sound, and every message printable."""
    source = Source("m.rscd", text)
    tree, diagnostics = parse(source)
    assert tree is not None or has_errors(diagnostics)
    for diagnostic in diagnostics:
        assert 0 <= diagnostic.span.start <= diagnostic.span.end <= len(text)
    assert len(diagnostics) <= 101
    render_all(diagnostics, color=True)
    return tree, diagnostics


@settings(max_examples=500)
@given(st.text())
def test_any_text(text: str) -> None:
    check(text)


@settings(max_examples=500)
@given(
    st.lists(st.sampled_from(TOKENS), max_size=60).map(" ".join), st.sampled_from(["", "robot R {"])
)
def test_any_tokens(text: str, start: str) -> None:
    check(start + text)


@st.composite
def mutated(draw: st.DrawFn) -> str:
    """A real model with some things cut out, put in or moved."""
    text = draw(st.sampled_from(MODELS))
    for _ in range(draw(st.integers(1, 6))):
        at = draw(st.integers(0, len(text)))
        match draw(st.sampled_from(["cut", "put", "move"])):
            case "cut":
                text = text[:at] + text[at + draw(st.integers(1, 60)) :]
            case "put":
                text = text[:at] + draw(st.sampled_from(TOKENS)) + text[at:]
            case _:
                other = draw(st.integers(0, len(text)))
                text = text[:at] + text[other : other + draw(st.integers(1, 60))] + text[at:]
    return text


@settings(max_examples=200)
@given(mutated())
def test_mutated_models(text: str) -> None:
    check(text)


def test_every_truncation_is_exactly_one_error() -> None:
    text = MODELS[0]
    # Before each word, inside it and behind it: between these nothing differs.
    words = [match.span() for match in re.finditer(r"\w+|\S", text)]
    for length in sorted({at for start, end in words[:-1] for at in (start, start + 1, end)}):
        _, diagnostics = parse(Source("m.rscd", text[:length]))
        assert len(diagnostics) == 1, render_all(diagnostics)


@pytest.mark.parametrize("text", MODELS, ids=["example", "large"])
def test_a_wrong_brace_is_exactly_one_error(text: str) -> None:
    for at, character in enumerate(text):
        if character in "{}":
            for changed in (text[:at] + text[at + 1 :], text[:at] + character + text[at:]):
                _, diagnostics = check(changed)
                assert len(diagnostics) == 1, render_all(diagnostics)


NONSENSE = {
    "parentheses": ("(" * 1_000_000, 1),
    "parentheses in a model": ("robot R { requirement a needs " + "(" * 1_000_000, 1),
    "opening braces": ("robot R {" + "{" * 1_000_000, 2),
    "closing braces": ("robot R {" + "}" * 1_000_000, 1),
    "negations": ("robot R { requirement a needs " + "!" * 1_000_000 + "a }", 1),
    "digits": ("robot R { requirement a needs " + "9" * 1_000_000 + " }", 1),
    "digits of a bound": (
        "robot R { datatype object O { x: integer(0.." + "9" * 5_000 + ") } }",
        1,
    ),
    "infinite double": ("robot R { requirement a needs 1e999 }", 1),
    "indexes": ("robot R { requirement a needs a" + "[1]" * 50_000 + " }", 0),
    "large index": ("robot R { requirement a needs a[99999999999999999999999] }", 1),
    "implications": ("robot R { requirement a needs " + " => ".join(["a"] * 20_000) + " }", 1),
    "sums": ("robot R { requirement a needs " + " + ".join(["a"] * 20_000) + " > 0 }", 1),
    "connectives": ("robot R { requirement a needs " + " and b or ".join(["a"] * 20_000) + " }", 0),
    "arrays": ("robot R { datatype object A { x: " + "array(" * 50_000 + " } }", 1),
    "objects": ("robot R { provide a with " + "{ a: " * 50_000 + " }", 1),
    "comments": ("robot R { " + "/**/" * 50_000 + "}", 0),
    "one comment": ("robot R { /*" + "x" * 1_000_000 + "*/ }", 0),
    "quotes": ("robot R { " + '"' * 100_001, 1),
    "semicolons": ("robot R { " + "; a " * 50_000 + "}", 101),
    "components": ("robot R { " + "component A { " * 20_000 + "}", 101),
    "early ends": ("robot R { " + "} component A { } " * 10_000 + "}", 1),
    "misspelt": ("robot R { component A { x\n" + "\n".join(f"acton{i}" for i in range(9_000)), 101),
    "lines": ("\n" * 1_000_000, 1),
}


@pytest.mark.parametrize("kind", NONSENSE)
def test_large_nonsense_is_answered_briefly(kind: str) -> None:
    text, most = NONSENSE[kind]
    found = check(text)[1]
    # pytest would print the text.
    if len(found) > most:
        pytest.fail(f"{len(found)} diagnostics, the first: {found[0].message}")
