"""Limits on processor time: of the synthesis in checks that run at every edit, of explanations."""

from __future__ import annotations

import math
import signal
import threading
import time
from collections.abc import Iterator
from contextlib import contextmanager
from types import FrameType

from robosc import limits
from robosc.errors import StateSpaceError
from robosc.progress import Progress

_AGAIN = 0.5
"""Seconds after which the timer fires again: the first error may have been swallowed."""

_time_is_up: list[StateSpaceError] = []
"""What the timer raised last."""


def lost_error() -> BaseException:
    """Return what a signal raised last, for callers of libraries that lose errors of signals."""
    return _time_is_up[-1] if _time_is_up else KeyboardInterrupt()


class Limited:
    """A progress callback that raises once the processor time is used up."""

    def __init__(self, seconds: float, progress: Progress | None, told: str) -> None:
        self._seconds = seconds
        self._progress = progress
        self._told = told.format(seconds)
        self._end = time.process_time() + seconds
        self.has_timer = _has_timer() and 0 < seconds < math.inf

    def __call__(self, what: str, done: int, most: int) -> None:
        if time.process_time() > self._end:
            self.stop()
        if self._progress is not None:
            self._progress(what, done, most)

    def stop(self, signum: int = 0, frame: FrameType | None = None) -> None:
        """Raises:
        StateSpaceError: in any case.
        """
        _time_is_up.append(StateSpaceError(self._told))
        raise _time_is_up[-1]

    def renew(self) -> None:
        """Give what follows as much time again."""
        self._end = time.process_time() + self._seconds
        if self.has_timer:
            signal.setitimer(signal.ITIMER_PROF, self._seconds, _AGAIN)


@contextmanager
def processor_time(
    seconds: float,
    progress: Progress | None,
    told: str = "it takes more than {:g} s; 'robosc synthesize' has no time limit",
) -> Iterator[Limited]:
    """Return a progress callback that raises once ``seconds`` of processor time are used up.

    ``told`` is the error, with the seconds. ``progress`` is called, too. In the main thread a timer
    (SIGPROF) also interrupts code that reports no progress, unless the timer is already in use, as
    by a profiler.

    Raises:
        StateSpaceError: the time is up.
    """
    limited = Limited(seconds, progress, told)
    if not limited.has_timer:
        yield limited
        return
    before = signal.signal(signal.SIGPROF, limited.stop)
    limited.renew()
    try:
        try:
            yield limited
        finally:  # the timer may fire even here, but not twice
            signal.setitimer(signal.ITIMER_PROF, 0)
    finally:
        signal.setitimer(signal.ITIMER_PROF, 0)
        signal.signal(signal.SIGPROF, before)
        _time_is_up.clear()


def _has_timer() -> bool:
    return (
        hasattr(signal, "setitimer")
        and threading.current_thread() is threading.main_thread()
        and signal.getsignal(signal.SIGPROF) is signal.SIG_DFL
    )


class TimeIsUp(Exception):
    """The time for explanations is used up."""


class ExplanationTime:
    """The processor time that explanations may take, of all independent parts together.

    ``seconds`` None: as long as synthesis has taken, within ``limits.EXPLAINING_SECONDS``.
    """

    def __init__(self, seconds: float | None = None) -> None:
        self._given = seconds
        self._synthesis = 0.0
        self._used = 0.0
        self._since: float | None = None

    @contextmanager
    def running(self, synthesis: float) -> Iterator[None]:
        """Count the time meanwhile; ``synthesis`` are the seconds of what is explained."""
        self._synthesis += synthesis
        self._since = time.process_time()
        try:
            yield
        finally:
            self._used, self._since = self._spent, None

    @property
    def seconds(self) -> float:
        """How much there is in all."""
        least, most = limits.EXPLAINING_SECONDS
        return min(max(self._synthesis, least), most) if self._given is None else self._given

    @property
    def _spent(self) -> float:
        return self._used + (0.0 if self._since is None else time.process_time() - self._since)

    @property
    def is_over(self) -> bool:
        return self._spent >= self.seconds

    def check(self) -> None:
        """Raises:
        TimeIsUp: it is used up.
        """
        if self.is_over:
            raise TimeIsUp

    def give_up(self) -> None:
        """Raises:
        TimeIsUp: in any case, for what would take too much memory.
        """
        raise TimeIsUp
