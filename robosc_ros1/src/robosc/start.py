"""Entry of the executables: Ctrl-C ends them quietly, also while their modules are being loaded."""

from __future__ import annotations

import os
import sys

_INTERRUPTED = 130

try:
    import signal
except KeyboardInterrupt:  # it takes its time to load what it needs
    os._exit(_INTERRUPTED)

TYPE_CHECKING = False  # that of typing takes its time, too
if TYPE_CHECKING:
    from types import FrameType

_IMPORTING = "<frozen importlib._bootstrap>"


def run(*verb: str) -> int:
    """Run the command line, its verb given or its first word; the exit code."""
    heeded = signal.getsignal(signal.SIGINT) is signal.default_int_handler  # else it is ignored
    if heeded:
        signal.signal(signal.SIGINT, _interrupt)
    from robosc.cli import main

    code = main([*verb, *sys.argv[1:]])
    if heeded:
        signal.signal(signal.SIGINT, signal.SIG_DFL)  # Python's own end is no time for exceptions
    if code == _INTERRUPTED or "oxidd" in sys.modules:
        _leave(code)
    return code


def _leave(code: int) -> None:
    """End the process, and do not free decision diagrams or a large model first, which takes up to
    a second."""
    import atexit

    atexit._run_exitfuncs()
    try:
        sys.stdout.flush()
        sys.stderr.flush()
    except (OSError, ValueError):
        return  # Python knows what to do with streams that are closed
    os._exit(code)


def _interrupt(number: int, frame: FrameType | None) -> None:
    """Raise KeyboardInterrupt, but not within an import.

    Verbs load what they need when they need it, and libraries that are interrupted while they are
    loaded raise whatever they like: numpy an ImportError.
    """
    while frame is not None:
        if frame.f_code.co_filename == _IMPORTING:
            os._exit(_INTERRUPTED)
        frame = frame.f_back
    raise KeyboardInterrupt
