"""Whatever becomes of a model while it is edited, each verb ends with an exit code and in words."""

from __future__ import annotations

import random
import re
from collections.abc import Callable
from pathlib import Path

import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from ros_support import EXAMPLES, REPOSITORY

from robosc.cli import main

TESTS = REPOSITORY / "robosc_ros1" / "test"
MODELS = [
    *sorted((TESTS / "faulty").glob("*.rscd")),
    *sorted((TESTS / "golden" / "models").glob("*.rscd")),
    EXAMPLES / "line_follower_first_edition" / "line_follower.rscd",
]
VERBS = (
    ("check",), ("check", "--json"), ("synthesize", "--json"), ("explore", "--limit", "500"),
    ("verify",), ("generate", "--force"), ("generate", "--target", "ros2", "--force"),
    ("export", "--format", "cif"), ("export", "--format", "dot"), ("format", "--check"),
    ("simulate", "--script", "/dev/null"),
)  # fmt: skip
TOKEN = re.compile(r'\s+|//[^\n]*|"[^"\n]*"|\w+|->|:=|=>|!=|<=|>=|\.\.|.', re.DOTALL)
JUNK = ("\0", "{", "}", '"', "/*", "\\", "\ufeff", "\r", "1e999", "^", "value", "-1", "\x1b[31m")

Mutation = Callable[[random.Random, list[str]], None]


def delete(rng: random.Random, parts: list[str]) -> None:
    del parts[rng.randrange(len(parts))]


def repeat(rng: random.Random, parts: list[str]) -> None:
    at = rng.randrange(len(parts))
    parts[at:at] = [parts[at], " "]


def swap(rng: random.Random, parts: list[str]) -> None:
    one, other = rng.randrange(len(parts)), rng.randrange(len(parts))
    parts[one], parts[other] = parts[other], parts[one]


def replace(rng: random.Random, parts: list[str]) -> None:
    parts[rng.randrange(len(parts))] = rng.choice([*parts, *JUNK])


def cut(rng: random.Random, parts: list[str]) -> None:
    del parts[rng.randrange(1, len(parts)) :]


@pytest.mark.slow
@settings(
    max_examples=80,
    suppress_health_check=[HealthCheck.function_scoped_fixture, HealthCheck.too_slow],
)
@given(
    seed=st.integers(0, 2**32),
    by_line=st.booleans(),
    mutate=st.sampled_from([delete, repeat, swap, replace, cut]),
    verb=st.sampled_from(VERBS),
)
def test_no_change_of_a_model_makes_a_verb_fail(
    seed: int,
    by_line: bool,
    mutate: Mutation,
    verb: tuple[str, ...],
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
) -> None:
    rng = random.Random(seed)
    original = rng.choice(MODELS)
    text = original.read_text(encoding="utf-8", errors="replace")
    parts = text.splitlines(keepends=True) if by_line else TOKEN.findall(text)
    for _ in range(rng.choice([1, 1, 2])):
        mutate(rng, parts)
    (tmp_path / "model.rscd").write_text("".join(parts), encoding="utf-8", newline="")
    monkeypatch.chdir(tmp_path)
    library = () if verb[0] == "format" else ("--library-path", str(original.parent))
    code = main([*verb, "model.rscd", *library])
    told = capsys.readouterr()
    assert code in (0, 1, 2, 3, 4)
    if code:
        assert told.err or told.out
    if code == 2:  # the file can be read and the words are right
        assert re.search("holds a library|no name for a package", told.err)
