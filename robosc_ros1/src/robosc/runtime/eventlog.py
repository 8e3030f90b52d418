"""A log of events, one JSON document per line, in files that are rotated by size."""

from __future__ import annotations

from pathlib import Path
from typing import IO, List, Optional

__all__ = ["EventLog"]


class EventLog:
    """``path`` is the current file; older ones are ``path.1`` (newest) to ``path.<keep>``."""

    def __init__(self, path: str, limit: int, keep: int) -> None:
        self._path = Path(path).expanduser()
        self._limit = limit
        self._keep = keep
        self._file: Optional[IO[str]] = None

    def write(self, lines: List[str]) -> None:
        """Append the lines and flush. Raises OSError if the file cannot be written."""
        for line in lines:
            if self._file is None:
                self._path.parent.mkdir(parents=True, exist_ok=True)
                self._file = self._path.open("a", encoding="utf-8")
            self._file.write(line + "\n")
            if self._file.tell() >= self._limit:
                self._rotate()
        if self._file is not None:
            self._file.flush()

    def _rotate(self) -> None:
        if self._file is not None:
            self._file.close()
            self._file = None
        if self._keep == 0:
            self._path.unlink()
            return
        for number in range(self._keep - 1, 0, -1):
            older = self._numbered(number)
            if older.exists():
                older.replace(self._numbered(number + 1))
        self._path.replace(self._numbered(1))

    def _numbered(self, number: int) -> Path:
        return self._path.with_name("%s.%d" % (self._path.name, number))
