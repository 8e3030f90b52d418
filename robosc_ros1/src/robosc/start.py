"""Entry of the executables: Ctrl-C ends them quietly, also while their modules are being loaded.

What a command loads and makes lives until it ends, so Python looks for garbage rarely: with its own
thresholds that would be a quarter of the time of a short command.
"""

from __future__ import annotations

import gc
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
_THRESHOLDS = (500_000, 20, 20)
"""New objects between two searches for garbage (Python's own: 700), and how often older ones are
searched as well."""


def run(*verb: str) -> int:
    """Run the command line, its verb given or its first word; the exit code."""
    heeded = signal.getsignal(signal.SIGINT) is signal.default_int_handler  # else it is ignored
    if heeded:
        signal.signal(signal.SIGINT, _interrupt)
    gc.set_threshold(*_THRESHOLDS)
    words = [*verb, *sys.argv[1:]]
    if words == ["--version"]:  # asked for by scripts, and in prompts
        from robosc import __version__

        print(f"robosc {__version__}")
        return 0
    if sys.hexversion < 0x030A0000:  # as of Ubuntu 20.04, whose rosrun finds robosc all the same
        version = sys.version.partition(" ")[0]
        said = f"{sys.executable} is Python {version}, and robosc needs 3.10 or newer"
        print(f"error: {said}; see Start in the README", file=sys.stderr)
        return 2
    from robosc.cli import main

    code = main(words)
    if heeded:
        signal.signal(signal.SIGINT, signal.SIG_DFL)  # Python's own end is no time for exceptions
    _leave(code)
    return code


def _leave(code: int) -> None:
    """End the process, and do not look for garbage or free what was made first: a fifth of the time
    of a short command, and up to a second for large diagrams."""
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
    loaded raise whatever they like.
    """
    while frame is not None:
        if frame.f_code.co_filename == _IMPORTING:
            os._exit(_INTERRUPTED)
        frame = frame.f_back
    raise KeyboardInterrupt
