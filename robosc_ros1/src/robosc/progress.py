"""Reports of progress of long work, and a line on the terminal that shows them."""

from __future__ import annotations

import time
from collections.abc import Callable
from typing import TextIO, TypeAlias

Progress: TypeAlias = Callable[[str, int, int], None]
"""Called at intervals: what is being computed, how far it is, and the most it can be."""

_WIDTH = 30


class ProgressLine:
    """Draws ``synthesis [######......] 1,234 of 5,678`` once work has lasted for a second.

    Call it as often as you like with what is being done, how far it is, and the most it can be;
    it draws ten times a second at the most. ``clear`` takes the line away. Does nothing at all
    unless the stream is a terminal.
    """

    def __init__(self, stream: TextIO, after: float = 1.0) -> None:
        self._stream = stream
        self._next = time.monotonic() + after if stream.isatty() else float("inf")
        self._drawn = 0

    def __call__(self, what: str, done: int, most: int) -> None:
        now = time.monotonic()
        if now < self._next:
            return
        self._next = now + 0.1
        share = min(1.0, done / most) if most else 0.0
        bar = "#" * round(share * _WIDTH)
        line = f"{what} [{bar:.<{_WIDTH}}] {done:,} of at most {most:,}"
        self._stream.write(f"\r{line:<{self._drawn}}")
        self._stream.flush()
        self._drawn = len(line)

    def clear(self) -> None:
        if self._drawn:
            self._stream.write(f"\r{'':{self._drawn}}\r")
            self._stream.flush()
            self._drawn = 0
