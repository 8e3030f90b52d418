"""Long lines of generated files that are not Python, and of data."""

from __future__ import annotations

import ast
from typing import Any
from xml.etree import ElementTree

import pytest
from emit.golden_packages import PACKAGES, package_of

from robosc.emit.controller.python_literals import assignment
from robosc.emit.write.line_breaks import WIDTH
from robosc.emit.write.text_breaks import break_comments, break_markdown, break_xml

GROUP = "golden"
"""One process makes the packages, for all tests that look at them."""

WORDS = "many words " * 7


def test_attributes_of_xml_go_below_one_another() -> None:
    line = f"""  <arg name="some" default="$(find a)/b c" doc="{WORDS}"/>"""
    broken = break_xml(line)
    assert (
        broken
        == f"""\
  <arg name="some" default="$(find a)/b c"
       doc="{WORDS}"/>"""
    )
    assert ElementTree.fromstring(broken).attrib == ElementTree.fromstring(line).attrib
    # The rest of this one stands on the next line already.
    start = f"""<node if="$(eval arg('ns') == '')" name="{WORDS}" pkg="a\""""
    assert break_xml(start).split("\n") == [
        """<node if="$(eval arg('ns') == '')\"""",
        f'''      name="{WORDS}" pkg="a"''',
    ]


def test_texts_and_comments_of_xml_are_filled() -> None:
    assert break_xml(f"  <description>{WORDS * 2}</description>").split("\n") == [
        "  <description>",
        f"    {'many words ' * 8}many",
        f"    {('words many ' * 5)}words",
        "  </description>",
    ]
    assert break_xml(f"<!-- {'w' * 50} {'x' * 50} -->") == f"<!-- {'w' * 50}\n     {'x' * 50} -->"


def test_comments_of_settings_are_filled() -> None:
    text = f"a: 1\n  # {'w' * 50} {'x' * 50}\n  name: {WORDS * 2}"
    assert break_comments(text) == f"a: 1\n  # {'w' * 50}\n  # {'x' * 50}\n  name: {WORDS * 2}"


@pytest.mark.parametrize(
    ("text", "expected"),
    [
        ("one\ntwo\n\n- three\n- four", "one two\n\n- three\n- four"),
        (f"| {WORDS}{WORDS} |", f"| {WORDS}{WORDS} |"),
        (f"{WORDS}{WORDS}more\nend", f"{WORDS}many words many words\n{'many words ' * 5}more end"),
        (
            f"- **a**: `{'x or ' * 18}y` (as required)\n  - {'w' * 60} and {'x' * 50}",
            f"- **a**: `{('x or ' * 18).strip()}\n  y` (as required)\n  - {'w' * 60} and\n    {'x' * 50}",
        ),
        # No line begins with what Markdown would take for a quotation or an item.
        (f"{'w ' * 49}a > b c", f"{('w ' * 49).strip()}\na > b c"),
        (f"{'w ' * 48}a - 1 b", f"{('w ' * 48).strip()}\na - 1 b"),
        (
            f"```\nrun {'w' * 60} {'x' * 60}\n```\n```mermaid\n{WORDS * 2}\n```",
            f"```\nrun {'w' * 60} \\\n    {'x' * 60}\n```\n```mermaid\n{WORDS * 2}\n```",
        ),
    ],
)
def test_paragraphs_and_commands_of_markdown(text: str, expected: str) -> None:
    assert break_markdown(text) == expected


@pytest.mark.parametrize(
    "value",
    [
        {},
        {"a": [], "b": (1,), "c": {"d": None, "e": True, 'f"': -1.5}},
        {"a": [["x", {"y": list(range(40))}], ("z",)], "long": WORDS * 3, "w": "w" * 120},
        [WORDS * 2, "\n\\" + WORDS * 2, ("a" * 60, "b" * 60)],
    ],
)
def test_data_are_the_same_in_short_lines(value: Any) -> None:
    text = assignment("DATA", value)
    (statement,) = ast.parse(text).body
    assert isinstance(statement, ast.Assign)
    assert ast.literal_eval(statement.value) == value
    assert [line for line in text.split("\n") if len(line) > WIDTH and "w" * 120 not in line] == []


@pytest.mark.parametrize(("model", "target", "mode"), PACKAGES)
def test_no_line_of_a_package_is_too_long(model: str, target: str, mode: str) -> None:
    """But for scripts, of which each line is a statement that cannot be broken."""
    for path, file in package_of(model, target, mode).files.items():
        if path.endswith(".sim"):
            continue
        lines = file.content.split("\n")
        assert [line for line in lines if len(line) > WIDTH and line[0] != "|"] == [], path
