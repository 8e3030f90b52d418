"""Frozen classes are as Python's own dataclasses, but compile no method before it is called."""

from __future__ import annotations

import ast
import builtins
import copy
import dataclasses
from dataclasses import field
from typing import Any

import pytest
from ros_support import SOURCES

from robosc import lazy_dataclasses

LATE = lazy_dataclasses.dataclass
OWN = ("interface.py", "pipeline.py")
"""Modules of few classes with Python's own: their signatures are shown to users, or are defaults."""


def classes(dataclass: Any, slots: bool) -> tuple[Any, Any, Any]:
    @dataclass(frozen=True, slots=slots)
    class Base:
        span: int = field(compare=False, repr=False, kw_only=True)

    @dataclass(frozen=True, slots=slots)
    class Node(Base):
        """Its text."""

        name: str
        parts: list[int] = field(default_factory=list)
        kept: int | None = field(default=None, init=False, compare=False, repr=False)
        last: str = ""

        def __hash__(self) -> int:
            return 7

    @dataclass(frozen=True, slots=slots, repr=False, eq=False)
    class Sum:
        numbers: tuple[int, ...] = (1,)

        def __post_init__(self) -> None:
            object.__setattr__(self, "numbers", (sum(self.numbers),))

    return Base, Node, Sum


@pytest.mark.parametrize("slots", [False, True])
@pytest.mark.parametrize("dataclass", [dataclasses.dataclass, LATE])
def test_what_python_makes(dataclass: Any, slots: bool) -> None:
    base, node, total = classes(dataclass, slots)
    one, two = node("a", span=1), node("a", [], span=2)
    assert one == two
    assert hash(one) == 7
    assert one != node("a", last="b", span=1)
    assert base(span=1) == base(span=2) != one
    assert hash(base(span=1)) == hash(base(span=2))
    assert one.__eq__(base(span=1)) is NotImplemented
    assert (one.kept, one.parts, two.span, node.__doc__) == (None, [], 2, "Its text.")
    assert one.parts is not node("a", span=1).parts
    assert repr(one).endswith("Node(name='a', parts=[], last='')")
    assert dataclasses.replace(one, name="c") == node("c", span=1)
    assert node.__match_args__ == ("name", "parts", "last")
    assert total((1, 2)).numbers == (3,)
    assert total() != total()
    assert repr(total()).startswith("<")
    assert hasattr(one, "__dict__") is not slots
    copied = copy.deepcopy(one)
    assert copied == one
    assert copied.parts is not one.parts
    for change in (lambda: setattr(one, "name", "b"), lambda: delattr(one, "name")):
        with pytest.raises(dataclasses.FrozenInstanceError):
            change()
    for wrong in (lambda: node(), lambda: node("a"), lambda: base(1)):
        with pytest.raises(TypeError, match="__init__"):
            wrong()


def test_nothing_is_compiled_before_it_is_called(monkeypatch: pytest.MonkeyPatch) -> None:
    compiled: list[str] = []
    real = builtins.exec
    monkeypatch.setattr(builtins, "exec", lambda text, *known: compiled.append(text) or real(text, *known))  # fmt: skip

    @LATE(frozen=True, slots=True)
    class Pair:
        one: int
        other: int

    assert not compiled
    assert {Pair(1, 2): "found"}[Pair(1, 2)] == "found"
    assert [text.partition("(")[0] for text in compiled] == [
        "def __init__", "def __hash__", "def __eq__",
    ]  # fmt: skip


def test_all_frozen_classes_are_such() -> None:
    """A command would take a quarter longer."""
    for file in sorted((SOURCES / "robosc").rglob("*.py")):
        tree = ast.parse(file.read_bytes())
        frozen = any(
            isinstance(node, ast.Call)
            and getattr(node.func, "id", "") == "dataclass"
            and any(word.arg == "frozen" for word in node.keywords)
            for node in ast.walk(tree)
        )
        names = {
            alias.name
            for node in ast.walk(tree)
            if isinstance(node, ast.ImportFrom) and node.module == "dataclasses"
            for alias in node.names
        }
        assert not (frozen and "dataclass" in names) or file.name in OWN, file
