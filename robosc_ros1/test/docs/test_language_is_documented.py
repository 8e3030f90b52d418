"""The page of the language has every row of the language's tables."""

from __future__ import annotations

import re
from pathlib import Path

from robosc.language.attributes import ATTRIBUTES
from robosc.language.functions import AGGREGATES, CALLS
from robosc.language.keywords import KEYWORDS
from robosc.language.operators import BINARY, UNARY

PAGE = (Path(__file__).parents[3] / "docs" / "language.md").read_text(encoding="utf-8")
_FENCED = re.compile(r"^ *```.*?^ *```$", re.MULTILINE | re.DOTALL)
IN_TEXT = re.findall(r"`[^`\n]+`", _FENCED.sub("", PAGE))
"""What sentences and tables of the page show as code."""
IN_CODE = [*_FENCED.findall(PAGE), *IN_TEXT]


def missing(names: list[str], shown: list[str], form: str = r"\b{}\b") -> list[str]:
    text = "\n".join(shown)
    return [name for name in names if not re.search(form.format(re.escape(name)), text)]


def test_each_attribute_is_in_the_text() -> None:
    assert missing([attribute.name for attribute in ATTRIBUTES], IN_TEXT) == []


def test_each_function_is_in_the_text() -> None:
    called = [o.spelling for o in (*CALLS.values(), *AGGREGATES.values()) if not o.written]
    assert missing(called, IN_TEXT, r"\b{}\(") == []


def test_each_keyword_is_in_an_example_or_in_the_text() -> None:
    assert missing([*KEYWORDS], IN_CODE) == []


def test_each_operator_is_in_an_example_or_in_the_text() -> None:
    operators = [o.spelling for o in (*BINARY.values(), *UNARY.values())]
    assert missing(operators, IN_CODE, "{}") == []


def test_what_the_page_does_not_have_is_found() -> None:
    assert missing(["type", "typo"], ["`type: T`"]) == ["typo"]
    assert missing(["max", "maximum"], ["`max(a, b)`, maximum"], r"\b{}\(") == ["maximum"]
