"""Reports of progress of long work, and a line on the terminal that shows them."""

from __future__ import annotations

import time
from collections.abc import Callable
from math import log10
from typing import TextIO, TypeAlias

Progress: TypeAlias = Callable[[str, int, int], None]
"""Called at intervals: what is being computed, how far it is, and the most it can be."""

_WIDTH = 30
_MANY = 10**12


class ProgressLine:
    """Draws ``synthesis [######......] 1,234 of 5,678`` once work has lasted for a second.

    Call it as often as you like with what is being done, how far it is, and the most it can be;
    it draws ten times a second at the most. ``clear`` takes the line away. Does nothing at all
    unless the stream is a terminal. Of very many the bar shows the share of the digits: sets of
    states grow by factors.
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
        bar = "#" * round(_share(done, most) * _WIDTH)
        line = f"{what} [{bar:.<{_WIDTH}}] {_amount(done)} of at most {_amount(most)}"
        self._stream.write(f"\r{line:<{self._drawn}}")
        self._stream.flush()
        self._drawn = len(line)

    def clear(self) -> None:
        if self._drawn:
            self._stream.write(f"\r{'':{self._drawn}}\r")
            self._stream.flush()
            self._drawn = 0


def _share(done: int, most: int) -> float:
    if most < 1:
        return 0.0
    share = log10(max(done, 1)) / log10(most) if most > _MANY else done / most
    return min(1.0, share)


def _amount(number: int) -> str:
    return f"{number:,}" if number <= _MANY else f"10^{int(log10(number))}"
