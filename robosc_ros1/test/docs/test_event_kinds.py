"""Documents name the kinds of events that the language has, all of them and no others."""

from __future__ import annotations

import json
from collections.abc import Iterator
from itertools import product
from pathlib import Path
from typing import Any

from robosc.language.events import COMMUNICATIONS, EventKind

SCHEMAS = Path(__file__).parents[3] / "docs" / "schemas"
KINDS = list(dict.fromkeys(kind.word for kind in EventKind))
SENT = {kind.word for kind in EventKind if kind.controllable and not kind.of_component}
"""The kinds of commands, those of served calls among them."""
PHASES = {
    name
    for sort in COMMUNICATIONS.values()
    for timeout, heard in product((True, False), (sort.may_be_heard, False))
    if (phases := sort.phases_of(timeout, heard)) is not None
    for name in phases.names
}


def enumerations(document: Any) -> Iterator[list[str]]:
    if isinstance(document, dict):
        if "enum" in document:
            yield document["enum"]
        for part in document.values():
            yield from enumerations(part)
    elif isinstance(document, list):
        for part in document:
            yield from enumerations(part)


def all_enumerations() -> list[list[str]]:
    return [
        found
        for path in sorted(SCHEMAS.glob("*.json"))
        for found in enumerations(json.loads(path.read_text(encoding="utf-8")))
    ]


def test_schemas_name_every_kind_of_event() -> None:
    found = [
        [k for k in kinds if k not in ("stop", "state", "operator")]
        for kinds in all_enumerations()
        if "timeout" in kinds and "tau" in kinds
    ]
    assert found and all(kinds == KINDS for kinds in found)


def test_schemas_name_every_kind_of_command() -> None:
    found = [
        {k for k in kinds if k not in ("tau", "state")}
        for kinds in all_enumerations()
        if "request" in kinds and "timeout" not in kinds
    ]
    assert found and all(kinds == SENT for kinds in found)


def test_schemas_name_every_phase() -> None:
    found = [set(phases) for phases in all_enumerations() if "idle" in phases]
    assert found and all(phases == PHASES for phases in found)
