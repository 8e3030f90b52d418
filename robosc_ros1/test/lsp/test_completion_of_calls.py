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
        ("outgoing |", ["action", "message", "service"]),
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
