"""What synthesis says about a model, computed in a process of its own.

Synthesis can take long, and Python that computes keeps an editor waiting. The process can be
stopped when the text changes. Request and answer are one JSON document each, on standard input and
output; places are offsets into the text that was sent.
"""

from __future__ import annotations

import json
import os
import sys
import threading
import time
from collections.abc import Mapping, Sequence
from dataclasses import asdict, replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

from robosc import errors, limits, remedies
from robosc.language.events import EventKind
from robosc.lazy_dataclasses import dataclass
from robosc.source import Source, Span, common_ends

if TYPE_CHECKING:
    from robosc.supervisor import Supervisor


@dataclass(frozen=True, slots=True)
class ShownGuard:
    """When a command (by key) is allowed; ``reasons`` with their remedies, why it is restricted.

    ``text`` is the guard, below the parts that it reads by their names.
    """

    communication: str
    event: str
    text: str
    status: str
    reasons: tuple[tuple[str, str | None], ...] = ()


@dataclass(frozen=True, slots=True)
class Derived:
    """What synthesis has found for a text: its diagnostics, and when each command is allowed."""

    source: Source
    diagnostics: tuple[errors.Diagnostic, ...] = ()
    guards: tuple[ShownGuard, ...] = ()


# --- on the side of the server -------------------------------------------------------------------


def command() -> list[str]:
    """Starts the process, wherever this robosc lies."""
    home = str(Path(__file__).resolve().parents[2])
    code = (
        "import sys; sys.path.insert(0, sys.argv[1]);"
        " from robosc.lsp.synthesis_process import main; main()"
    )
    return [sys.executable, "-c", code, home]


def request_for(source: Source, library_path: Sequence[str], texts: Mapping[str, str]) -> bytes:
    """``texts`` are those of other documents that are open, by path."""
    document = {
        "path": source.path,
        "text": source.text,
        "library_path": list(library_path),
        "texts": dict(texts),
    }
    return json.dumps(document).encode()


def derived_from(source: Source, text: bytes | str) -> Derived | None:
    """The answer about a text; None if the process was stopped or has failed."""
    try:
        document = json.loads(text)
    except ValueError:
        return None
    guards = (
        ShownGuard(**{**guard, "reasons": tuple(map(tuple, guard["reasons"]))})
        for guard in document["guards"]
    )
    diagnostics = (_diagnostic(source, item) for item in document["diagnostics"])
    return Derived(source, tuple(diagnostics), tuple(guards))


def _diagnostic(source: Source, item: Mapping[str, Any]) -> errors.Diagnostic:
    notes = (
        errors.Note(message, Span(source, *place) if place is not None else None)
        for message, place in item["notes"]
    )
    return errors.Diagnostic(
        errors.Severity(item["severity"]),
        item["code"],
        item["message"],
        Span(source, *item["place"]),
        _advice(item),
        tuple(notes),
    )


def _advice(item: Mapping[str, Any]) -> remedies.Hint | None:
    if item["remedy"] is None:
        hint: str | None = item["hint"]
        return hint
    change, parts = item["remedy"]
    return remedies.Remedy(item["hint"], remedies.Change(change), tuple(parts))


def moved(derived: Derived, source: Source) -> tuple[errors.Diagnostic, ...]:
    """Its diagnostics in a text that was changed since: those outside of what was changed."""
    before, after = derived.source.text, source.text
    if before == after:
        return derived.diagnostics
    head, tail = common_ends(before, after)
    shift = len(after) - len(before)
    found: list[errors.Diagnostic] = []
    for diagnostic in derived.diagnostics:
        span = diagnostic.span
        if span.end <= head:
            place = Span(source, span.start, span.end)
        elif span.start >= len(before) - tail:
            place = Span(source, span.start + shift, span.end + shift)
        else:
            continue
        found.append(replace(diagnostic, span=place, notes=()))
    return tuple(found)


# --- in the process ------------------------------------------------------------------------------


def main() -> None:
    server = os.getppid()
    threading.Thread(target=_end_with, args=(server,), daemon=True).start()
    request = json.load(sys.stdin)
    json.dump(answer(request), sys.stdout)


def _end_with(server: int) -> None:
    """Nobody waits for the answer when the server was killed."""
    while os.getppid() == server:
        time.sleep(0.5)
    os._exit(1)


def answer(request: Mapping[str, Any]) -> dict[str, Any]:
    """What the process says to a request, both as JSON documents."""
    from robosc import pipeline
    from robosc.lsp.analysis import Workspace

    nothing: dict[str, Any] = {"diagnostics": [], "guards": []}
    workspace = Workspace(library_path=request["library_path"])
    for path, text in request["texts"].items():
        workspace.put(path, text)
    source = Source(request["path"], request["text"])
    robot = workspace.analyse(source).reading.robot
    if robot is None:
        return nothing
    try:
        supervisor = pipeline.within_time(robot, max_states=limits.EDITOR_STATES)
    except errors.StateSpaceError as error:
        return {**nothing, "diagnostics": [_document(pipeline.unchecked(robot, error), source)]}
    return {
        "diagnostics": [
            _document(d, source) for d in supervisor.diagnostics if d.span.source is source
        ],
        "guards": [asdict(guard) for guard in _guards(supervisor)],
    }


def _document(diagnostic: errors.Diagnostic, source: Source) -> dict[str, Any]:
    def place(span: Span | None) -> list[int] | None:
        return None if span is None or span.source is not source else [span.start, span.end]

    remedy = diagnostic.remedy
    return {
        "severity": diagnostic.severity.value,
        "code": diagnostic.code,
        "message": diagnostic.message,
        "place": place(diagnostic.span),
        "hint": diagnostic.hint,
        "remedy": (remedy.change.value, remedy.parts) if remedy is not None else None,
        "notes": [[note.message, place(note.span)] for note in diagnostic.notes],
    }


def _guards(supervisor: Supervisor) -> list[ShownGuard]:
    return [
        ShownGuard(
            guard.event.key,
            guard.event.kind.word,
            "\n".join(supervisor.part_names.lines(guard.expr)),
            guard.status,
            tuple((e.reason, e.remedy) for e in supervisor.explanations if e.event == guard.event),
        )
        for guard in supervisor.guards
        if guard.event.kind is not EventKind.TAU
    ]
