"""Every row of the tables of keywords and of the lexer, compared with what is read and with Python."""

from __future__ import annotations

import ast

import pytest

from robosc.language.keywords import KEYWORDS
from robosc.language.operators import symbols
from robosc.language.tokens import ESCAPES, FOREIGN
from robosc.model.resolve import load
from robosc.source import Source

NAMED = """
robot R {{
    constant text: string = "{text}"
    component C {{
        outgoing message m with type: boolean
        incoming message go with type: none
        behaviour {{
            variable {name}: boolean
            initial marked state s {{ on response from m do {name} := value }}
        }}
    }}
    requirement go needs C.{name} {sign} true
}}
"""


def faults(name: str = "v", sign: str = "=", text: str = "") -> list[str]:
    """The errors of a model with this name, operator and text."""
    source = Source("words.rscd", NAMED.format(name=name, sign=sign, text=text))
    return [str(d) for d in load(source)[1] if d.severity.value == "error"]


@pytest.mark.parametrize("word", KEYWORDS)
def test_a_word_is_a_name_unless_it_is_reserved(word: str) -> None:
    assert bool(faults(word)) == KEYWORDS[word].reserved
    assert faults(f"^{word}") == []


@pytest.mark.parametrize(("sign", "meant"), FOREIGN.items())
def test_a_sign_of_another_language_is_told_with_the_one_that_is_meant(
    sign: str, meant: str
) -> None:
    assert meant in symbols(words=False) and sign not in symbols(words=False)
    (fault,) = faults(sign=sign)
    assert f"'{meant}'" in fault


def test_escapes_are_those_of_python() -> None:
    for letter in map(chr, range(0x20, 0x7F)):
        if letter in ESCAPES:
            assert ast.literal_eval(f"'\\{letter}'") == ESCAPES[letter]
        assert (faults(text=f"\\{letter}") == []) == (letter in ESCAPES)
