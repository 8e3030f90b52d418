"""At a terminal: completion, and the ways to leave."""

from __future__ import annotations

import os
import pty
import select
import signal
import sys
from collections.abc import Iterator

import pytest
from ros_support import SOURCES
from simulate.players import MODEL, line_follower, session

from robosc.simulate.session import Session
from robosc.simulate.terminal import completions


@pytest.fixture(scope="module")
def player() -> Session:
    return session(line_follower())


@pytest.mark.parametrize(
    ("before", "found"),
    [
        ("dist", ["distance.response"]),
        ("distance ", ["free", "obstructed"]),
        ("distance.response(o", ["obstructed"]),
        ("got", ["goto"]),
        ("goto Mot", ["Motor.moving", "Motor.stopped"]),
        ("expect Motor.moving and LineDetector.c", ["LineDetector.current_correction"]),
        ("expect en", ["enabled"]),
        ("expect enabled grab.e", ["grab.error"]),
        ("why mo", ["move.request"]),
        ("random ", []),
        ("nothing at all", []),
    ],
)
def test_words_that_fit(player: Session, before: str, found: list[str]) -> None:
    assert completions(player, before) == found


def test_everything_that_can_be_done_is_offered_at_first(player: Session) -> None:
    found = completions(player, "")
    assert found[0] == "distance.response"
    assert {"help", "quit", "stop.request"} <= set(found)


class Terminal:
    """A simulator at a terminal of its own."""

    def __init__(self, **environment: str) -> None:
        plain = {k: v for k, v in os.environ.items() if k != "NO_COLOR"}
        plain |= {"PYTHONPATH": str(SOURCES), "TERM": "xterm"} | environment
        arguments = [sys.executable, "-m", "robosc", "simulate", str(MODEL)]
        self.process, self.ours = pty.fork()
        if self.process == 0:
            os.execve(sys.executable, arguments, plain)
        self.shown = ""
        self.exit_code: int | None = None

    def type(self, keys: str) -> None:
        os.write(self.ours, keys.encode())

    def await_text(self, text: str) -> str:
        """What is shown before the text is; both are forgotten then."""
        while text not in self.shown:
            assert self._read(), self.shown
        before, _, self.shown = self.shown.partition(text)
        return before

    def await_end(self) -> str:
        """All that is shown to the end."""
        while self._read():
            pass
        self.exit_code = os.waitstatus_to_exitcode(os.waitpid(self.process, 0)[1])
        return self.shown

    def interrupt(self) -> str:
        """Press Ctrl-C until it ends: Python overlooks a signal just before it waits for a key."""
        self.type("\x03")
        while not select.select([self.ours], [], [], 1)[0]:
            self.type("\x03")
        return self.await_end()

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


@pytest.fixture
def terminal() -> Iterator[Terminal]:
    opened = Terminal()
    yield opened
    opened.close()


def test_events_are_typed_and_control_d_leaves(terminal: Terminal) -> None:
    assert "\x1b[" in terminal.await_text("it is idle")  # colours
    terminal.await_text("\n> ")
    terminal.type("distance free\r")
    terminal.await_text("current = free")
    terminal.await_text("\n> ")
    terminal.type("\x04")
    terminal.await_end()
    assert terminal.exit_code == 0


def test_control_c_interrupts_quietly(terminal: Terminal) -> None:
    terminal.await_text("\n> ")
    terminal.type("dist\t")
    terminal.await_text("distance.response")
    shown = terminal.interrupt()
    assert terminal.exit_code == 130
    assert shown.endswith("interrupted\r\n")
    assert "Traceback" not in shown


def test_no_color() -> None:
    plain = Terminal(NO_COLOR="1", TERM="dumb")
    shown = plain.await_text("it is idle")
    plain.close()
    assert "\x1b[" not in shown
