"""A simulator at a terminal of its own, for tests to type at."""

from __future__ import annotations

import fcntl
import os
import pty
import select
import signal
import struct
import sys
import termios

import pytest
from ros_support import SOURCES
from simulate.players import MODEL

__all__ = ["Terminal"]


class Terminal:
    """A simulator at a terminal of its own, with one of the libraries that read lines there."""

    def __init__(self, library: str, columns: int = 100, **environment: str) -> None:
        program = "import sys; from robosc.cli import main; "
        if library == "readline":
            program += "sys.modules['prompt_toolkit'] = None; "
        else:
            pytest.importorskip("prompt_toolkit")
        plain = {k: v for k, v in os.environ.items() if k not in ("NO_COLOR", "COLUMNS", "LINES")}
        plain |= {"PYTHONPATH": str(SOURCES), "TERM": "xterm", "PROMPT_TOOLKIT_NO_CPR": "1"}
        arguments = [sys.executable, "-c", f"{program}sys.exit(main())", "simulate", str(MODEL)]
        self.process, self.ours = pty.fork()
        if self.process == 0:
            self._resize(0, columns)
            os.execve(sys.executable, arguments, plain | environment)
        self.shown = ""
        self.exit_code: int | None = None

    def resize(self, columns: int) -> None:
        self._resize(self.ours, columns)

    @staticmethod
    def _resize(terminal: int, columns: int) -> None:
        fcntl.ioctl(terminal, termios.TIOCSWINSZ, struct.pack("HHHH", 40, columns, 0, 0))

    def type(self, keys: str) -> None:
        os.write(self.ours, keys.encode())

    def await_text(self, text: str) -> str:
        """What is shown before the text is; both are forgotten then."""
        while text not in self.shown:
            assert self._read(), self.shown
        before, _, self.shown = self.shown.partition(text)
        return before

    def await_prompt(self) -> str:
        """All that is shown before the next line may be typed."""
        before = self.await_text("it is idle")
        self.await_text(">")
        return before

    def await_end(self) -> str:
        """All that is shown to the end."""
        while self._read():
            pass
        self.exit_code = os.waitstatus_to_exitcode(os.waitpid(self.process, 0)[1])
        return self.shown

    def interrupt(self, shown: str) -> None:
        """Press Ctrl-C until this is shown: Python overlooks a signal just before it waits."""
        while shown not in self.shown:
            self.type("\x03")
            while shown not in self.shown and select.select([self.ours], [], [], 1)[0]:
                assert self._read(), self.shown
        self.await_text(shown)

    def _read(self) -> bool:
        """Read on; False at the end."""
        assert select.select([self.ours], [], [], 60)[0], self.shown
        try:
            part = os.read(self.ours, 65536)
        except OSError:  # how Linux tells that the other side is closed
            return False
        self.shown += part.decode()
        return bool(part)

    def close(self) -> None:
        if self.exit_code is None:
            os.kill(self.process, signal.SIGKILL)
            os.waitpid(self.process, 0)
        os.close(self.ours)
