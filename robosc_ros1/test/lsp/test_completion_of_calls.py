"""Completion and hover of services that the controller serves."""

from __future__ import annotations

from pathlib import Path

import pytest
from lsp.test_lsp_completion import offered

SHAPE = "outgoing message shape with type: Shape links shape"
ASK = SHAPE + "\n outgoing service ask with request: boolean, response: boolean links shape"


@pytest.mark.parametrize(
    ("new", "first"),
    [
        ("outgoing |", ["action", "message", "service", "transform"]),
        ("outgoing transform at |", ["with"]),
        ("outgoing transform at with |", ["from:", "max_age:", "rate:", "timeout:"]),
        ('outgoing transform at with from: "map", |', ["to:", "max_age:"]),
        ("outgoing service |", []),
        ("outgoing service ask |", ["with"]),
        ("outgoing service ask with |", ["request:", "type:", "identifier:"]),
        ("outgoing service ask with request: boolean, |", ["response:"]),
        ("outgoing service ask with request: boolean, response: none |", ["links"]),
    ],
)
def test_a_declaration(tmp_path: Path, new: str, first: list[str]) -> None:
    assert offered(tmp_path, SHAPE, new)[: len(first)] == first


def test_its_request_and_its_answers(tmp_path: Path) -> None:
    behaviour = ASK + "\n behaviour { initial marked state on_ { on %s } }"
    assert "ask" in offered(tmp_path, SHAPE, behaviour % "request from |")
    assert "ask" in offered(tmp_path, SHAPE, behaviour % "response to |")
    assert "ask" in offered(tmp_path, SHAPE, behaviour % "error to |")
    assert "ask" not in offered(tmp_path, SHAPE, behaviour % "cancel from |")


@pytest.mark.parametrize(
    ("new", "offers"),
    [
        ("state a |", {"performs"}),
        ("state a performs |", {"ask", "drive"}),
        ("state a performs ask |", {"meanwhile", "with", "then"}),
        ("state a performs ask meanwhile |", {"with", "then"}),
        ("state a performs ask.|", {"response", "error"}),
        ("state a performs ask then |", {"do", "goto"}),
        ("state a performs drive with { | }", {"linear"}),
        ("state a { state b performs drive with { | } }", {"linear"}),
        ("state a performs drive with { linear: { x: 1.0 } } |", {"then"}),
    ],
)
def test_what_a_state_performs(tmp_path: Path, new: str, offers: set[str]) -> None:
    behaviour = f"{ASK}\n behaviour {{ initial {new} }}"
    assert offers <= {*offered(tmp_path, SHAPE, behaviour)}


def test_its_answers_have_names(tmp_path: Path) -> None:
    whole = ASK + "\n behaviour { initial marked state on_ {} }"
    assert offered(tmp_path, SHAPE, f"{whole} provide ask.|")[:2] == ["error", "response"]
    assert "idle" in offered(tmp_path, SHAPE, f"{whole} requirement drive needs ask.|")
