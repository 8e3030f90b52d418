"""How the process of a generated node is told to end."""

from __future__ import annotations

import importlib.util
import sys
import threading
from types import FrameType
from typing import Any

from robosc.resources import templates_folder


def started() -> Any:
    """The module of generated packages, without a package."""
    path = templates_folder() / "common" / "node" / "start.py"
    spec = importlib.util.spec_from_file_location("start", path)
    assert spec is not None and spec.loader is not None
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


def test_a_signal_may_come_at_any_line_of_the_wait() -> None:
    """Its handler runs in the thread that waits, whatever that holds there."""
    ending = started().Ending()

    def interrupted(frame: FrameType, event: str, argument: Any) -> Any:
        ending.ask()
        return interrupted

    def wait() -> None:
        sys.settrace(interrupted)
        for _ in range(3):
            ending.wait()

    thread = threading.Thread(target=wait, daemon=True)
    thread.start()
    thread.join(60)
    assert not thread.is_alive()
