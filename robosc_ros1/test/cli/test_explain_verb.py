"""``explain`` tells what a code means; what is mistyped is answered by a suggestion."""

from __future__ import annotations

from collections.abc import Callable

import pytest
from ros_support import Completed

from robosc.codes import CODES
from robosc.resources import diagnostics_page, section

Robosc = Callable[..., Completed]


def test_every_code_has_a_section() -> None:
    page = diagnostics_page()
    assert page is not None
    text = page.read_text(encoding="utf-8")
    sections = {code: section(text, code) for code in CODES}
    assert all(found is not None and len(found) > 50 for found in sections.values())


def test_meaning_example_and_remedy(robosc: Robosc) -> None:
    done = robosc("explain", "unexpected-brace")
    assert done.returncode == 0
    assert done.stdout.startswith("unexpected-brace, error\n\nA closing brace has no opening one")
    assert "\n\n    robot R { } }\n\n" in done.stdout
    assert done.stdout.endswith("or move the declaration into its block.\n")


@pytest.mark.parametrize("code", CODES)
def test_it_is_text(robosc: Robosc, code: str) -> None:
    shown = robosc("explain", code).stdout
    assert "```" not in shown and "`" not in shown
    prose = [line for line in shown.splitlines() if not line.startswith("    ")]
    assert max(map(len, prose)) <= 88
    assert "**" not in shown and "](" not in shown and "\n\n\n" not in shown


@pytest.mark.parametrize(
    ("words", "told"),
    [
        (("explain", "neverallowed"), "error: no diagnostic has the code 'neverallowed'; did you mean 'never-allowed'?\n"),
        (("explain", "zzz"), "error: no diagnostic has the code 'zzz'; messages show it in brackets\n"),
    ],
)  # fmt: skip
def test_mistyped_code(robosc: Robosc, words: tuple[str, ...], told: str) -> None:
    done = robosc(*words)
    assert (done.returncode, done.stdout, done.stderr) == (2, "", told)


def test_mistyped_verb(robosc: Robosc) -> None:
    done = robosc("chekc", "model.rscd")
    assert done.returncode == 2
    assert done.stderr == "error: there is no verb 'chekc'; did you mean 'robosc check'?\n"
