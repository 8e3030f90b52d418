"""Messages to people on standard error, in colour where that is a terminal."""

from __future__ import annotations

import os
import sys
from collections.abc import Iterable
from pathlib import Path
from typing import TextIO

from robosc.errors import Diagnostic, render_all


def tell(diagnostics: Iterable[Diagnostic]) -> None:
    """Show what was found in a model."""
    if text := render_all(diagnostics, in_color(sys.stderr)):
        print(text, end="", file=sys.stderr)


def complain(message: str) -> None:
    """Tell why the command ends."""
    label = "\x1b[1;31merror:\x1b[0m" if in_color(sys.stderr) else "error:"
    print(label, message, file=sys.stderr)


def in_color(stream: TextIO) -> bool:
    """Whether what is written there may be coloured."""
    return stream.isatty() and not os.environ.get("NO_COLOR") and os.environ.get("TERM") != "dumb"


def command(started: str, other: str) -> str:
    """What starts another verb where this process is the verb ``started``.

    ``rosrun`` and ``ros2 run`` have an executable for each verb, and no ``robosc`` on PATH.
    """
    if Path(sys.argv[0]).name != started:
        return f"robosc {other}"
    return f"{'ros2 run' if os.environ.get('ROS_VERSION') == '2' else 'rosrun'} robosc {other}"
