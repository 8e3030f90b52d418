"""Files that a command line names: which are models, when they are saved, their layout."""

from __future__ import annotations

import time
from collections.abc import Iterable, Iterator
from pathlib import Path

from robosc.emit.write.whole_file import write_whole
from robosc.errors import ModelError, UsageError
from robosc.source import MODEL_SUFFIXES

_INTERVAL = 0.2
"""Seconds between two looks at the files: short for a person, and next to no load."""


def models(paths: Iterable[str]) -> Iterator[str]:
    """The paths, and for each that is a folder all models below it.

    Raises:
        UsageError: there are none.
    """
    for path in paths:
        if not Path(path).is_dir():
            yield path
            continue
        found = sorted(Path(path).rglob("*.rscd"))
        if not found:
            raise UsageError(f"there is no .rscd file in {path}")
        yield from map(str, found)


def saved(paths: Iterable[str | Path]) -> Iterator[None]:
    """Yield at once, and then whenever a model has been saved, added or removed.

    Watched are the files and what is beside them, because libraries are found there, and all below
    the paths that are folders.
    """
    places = [Path(path) for path in paths]
    before = None
    while True:
        now = dict(_times(places))
        if now != before:
            yield
        before = now
        time.sleep(_INTERVAL)


def format_file(path: str | Path, *, check: bool = False) -> bool:
    """Give a model file its canonical layout; whether it had (with ``check``: has) another one.

    Raises:
        UsageError: the file cannot be read or written.
        ModelError: it has errors of syntax. It is left as it is.
    """
    before, text = formatted(path)
    if before != text and not check:
        write_text(Path(path), text.decode())
    return before != text


def formatted(path: str | Path) -> tuple[bytes, bytes]:
    """The content of a model file (``-``: standard input), and the same in canonical layout.

    Line ends are ``\\r\\n`` if all of them were.

    Raises:
        UsageError: the file cannot be read.
        ModelError: it has errors of syntax.
    """
    from robosc.syntax.formatting.format import format_text
    from robosc.syntax.parser import read_bytes, source_of

    data = read_bytes(str(path))
    source, unreadable = source_of(str(path), data)
    if source is None:
        raise ModelError(unreadable)
    text = format_text(source).encode()
    if 0 < data.count(b"\n") == data.count(b"\r\n"):
        text = text.replace(b"\n", b"\r\n")
    return data, text


def write_text(path: Path, text: str) -> None:
    """Writes a result, line ends as they are, where the user wants it.

    Raises UsageError if that cannot be done.
    """
    try:
        write_whole(path, text.encode())
    except OSError as error:
        raise UsageError(f"cannot write {path}: {error.strerror}") from error


def _times(places: Iterable[Path]) -> Iterator[tuple[Path, tuple[int, int]]]:
    for place in places:
        near = place.rglob("*") if place.is_dir() else place.parent.glob("*")
        for file in near:
            if file.suffix in MODEL_SUFFIXES:
                try:
                    found = file.stat()
                except OSError:
                    continue  # an editor is replacing it
                yield file, (found.st_mtime_ns, found.st_size)
