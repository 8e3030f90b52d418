"""The event log of a generated node, read."""

from __future__ import annotations

import json
import re
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any, BinaryIO

from robosc import errors, limits, source
from robosc.language.events import EventKind
from robosc.lazy_dataclasses import dataclass

_KINDS = (*(kind.word for kind in EventKind), "stop", "state", "operator")
_OUTCOMES = (
    "applied", "mismatch", "failed", "stopped", "refused", "forbidden", "violated", "undecided",
    "withheld", "operated",
)  # fmt: skip


@dataclass(frozen=True)
class LogEntry:
    """A line of a log; ``document`` is all of it."""

    document: dict[str, Any]
    file: str
    line: int
    number: int
    kind: str
    name: str
    index: int
    value: Any
    outcome: str

    @property
    def shortened(self) -> bool:
        """Whether the value is a short form."""
        return bool(self.document.get("shortened"))

    @property
    def seen(self) -> bool:
        """Whether this is a command of another node, which a monitor has seen."""
        return bool(self.document.get("seen"))

    @property
    def text(self) -> str:
        name = f"{self.name}.{self.kind}" if self.name else self.kind
        return f"{name}{self.index}" if self.index else name


def read_log(log: str) -> Iterator[LogEntry]:
    """All events of a log (``-``: standard input) and its older parts, oldest first.

    A line that is no JSON, after others that are, was cut off when its node was killed, and is left
    out; if others of that run follow, their numbers show that it is missing.

    Raises:
        UsageError: a file cannot be read, or is no event log.
    """
    found = False
    for path in _files(log):
        try:
            with source.opened(path) as file:
                for number, line in enumerate(_lines(file), 1):
                    document = _document(line)
                    if line.strip() and (document is not None or not found):
                        yield entry_of(path, number, document)
                        found = True
        except (OSError, ValueError) as error:
            raise errors.UsageError(f"cannot read {path}: {_reason(error)}") from error


def _lines(file: BinaryIO) -> Iterator[bytes]:
    """Raises ValueError at a line that is longer than any event."""
    while line := file.readline(limits.LOG_LINE_BYTES + 1):
        if len(line) > limits.LOG_LINE_BYTES:
            raise ValueError(f"no event has more than {limits.LOG_LINE_BYTES >> 20} MB")
        yield line


def _document(line: bytes) -> Any:
    """The JSON of a line; None if it is none. Unlike Python's, it has no NaN and no infinities."""
    try:
        return json.loads(line, parse_constant=_no_json)
    except (ValueError, RecursionError):
        return None


def _no_json(constant: str) -> None:
    raise ValueError(f"{constant} is not JSON")


def _reason(error: OSError | ValueError) -> str:
    return (error.strerror if isinstance(error, OSError) else None) or str(error)


def _files(log: str) -> list[str]:
    """The log after its older parts, oldest first."""
    if log == "-":
        return [log]
    current = Path(log)
    pattern = re.compile(re.escape(current.name) + r"\.(\d+)")
    try:
        older = [
            (int(match[1]), str(path))
            for path in current.parent.iterdir()
            if (match := pattern.fullmatch(path.name))
        ]
    except OSError:
        older = []
    # While nothing has happened since the last rotation, there are only older parts.
    newest = [] if older and not current.exists() else [log]
    return [path for _, path in sorted(older, reverse=True)] + newest


def entry_of(file: str, line: int, document: Any) -> LogEntry:
    """The event of a document.

    Raises:
        UsageError: it is none.
    """
    match document:
        case {
            "version": 1,
            "number": int(number),
            "event": {"kind": str(kind), "name": str(name)} as event,
            "outcome": str(outcome),
        } if kind in _KINDS and outcome in _OUTCOMES and _has_forms(document):
            index = event.get("index", 0)
            if isinstance(index, int):
                value = event.get("value")
                return LogEntry(document, file, line, number, kind, name, index, value, outcome)
    raise errors.UsageError(f"{file}:{line}: this is not an event of a log, version 1")


def _has_forms(document: Mapping[str, Any]) -> bool:
    """Whether what is told beside an event has the forms of docs/schemas/event.schema.json, as far
    as those who follow a log rely on them."""
    beside = [document.get(name, {}) for name in ("effect", "parameters", "start")]
    if not all(isinstance(part, dict) for part in beside):
        return False
    effect = beside[0]
    groups = {name: effect.get(name, {}) for name in ("components", "variables", "communications")}
    return (
        all(isinstance(group, dict) for group in groups.values())
        and all(isinstance(state, str) for state in groups["components"].values())
        and all(isinstance(phase, bool) for phase in groups["communications"].values())
        and isinstance(effect.get("shortened", []), list)
    )
