"""Entry of the executables: Ctrl-C ends them quietly while their modules are still being loaded."""

from __future__ import annotations

import os
import signal
import sys

__all__ = ["run"]


def run(*verb: str) -> int:
    """Run the command line, its verb given or its first word; the exit code."""
    loading = signal.getsignal(signal.SIGINT) is signal.default_int_handler  # else it is ignored
    if loading:
        signal.signal(signal.SIGINT, lambda *_: os._exit(130))
    from robosc.cli import main

    if loading:
        signal.signal(signal.SIGINT, signal.default_int_handler)
    return main([*verb, *sys.argv[1:]])
