"""At a terminal: completion, lines as wide as it is, and the ways to leave."""

from __future__ import annotations

import fcntl
import os
import pty
import re
import select
import signal
import struct
import sys
import termios
from collections.abc import Iterator

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from ros_support import SOURCES
from simulate.players import MODEL, line_follower, session

from robosc.simulate.render import fitted
from robosc.simulate.session import Session
from robosc.simulate.terminal import completions

PAINT = re.compile(r"\x1b\[[0-9;?]*[a-zA-Z]")


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


@settings(derandomize=True, deadline=None)
@given(
    text=st.text(st.sampled_from("ab  \n,"), max_size=60),
    width=st.integers(1, 20),
)
def test_lines_fit_and_lose_no_word(text: str, width: int) -> None:
    found = fitted(text, width)
    assert found.split() == text.split()
    for line in found.splitlines():
        assert len(line) <= width or not line.strip() or " " not in line.strip()


def test_what_goes_on_stands_below_its_column() -> None:
    line = "  \x1b[31mmove.request\x1b[0m  requirement move needs Sensor.free  (file:3)"
    assert fitted(line, 40).splitlines() == [
        "  \x1b[31mmove.request\x1b[0m  requirement move needs",
        "                Sensor.free  (file:3)",
    ]


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


@pytest.fixture(params=["readline", "prompt_toolkit"])
def library(request: pytest.FixtureRequest) -> str:
    name: str = request.param
    return name


@pytest.fixture
def terminal(library: str) -> Iterator[Terminal]:
    opened = Terminal(library)
    yield opened
    opened.close()


def test_events_are_typed_and_control_d_leaves(terminal: Terminal) -> None:
    assert "\x1b[" in terminal.await_prompt()  # colours
    terminal.type("distance free\r")
    terminal.await_text("current = free")
    terminal.await_prompt()
    terminal.type("\x04")
    terminal.await_end()
    assert terminal.exit_code == 0


def test_words_are_completed_and_lines_called_back(terminal: Terminal) -> None:
    terminal.await_prompt()
    terminal.type("goto DistanceSensor.se\t")
    terminal.await_text("nsing")
    terminal.type("\r")
    terminal.await_text("DistanceSensor   \x1b[32msensing")
    terminal.await_prompt()
    terminal.type("\x1b[A\r")
    terminal.await_text("it holds already")


def test_control_c_interrupts_quietly(terminal: Terminal) -> None:
    terminal.await_prompt()
    terminal.type("dist\t")
    terminal.await_text("ance.response")
    shown = terminal.interrupt()
    assert terminal.exit_code == 130
    assert shown.endswith("interrupted\r\n")
    assert "Traceback" not in shown


def test_lines_are_as_wide_as_the_terminal_is_now(terminal: Terminal) -> None:
    terminal.await_prompt()
    for columns in (60, 45, 200):
        terminal.resize(columns)
        terminal.type("show\r")
        terminal.await_text("LineFollower")
        lines = [PAINT.sub("", line) for line in terminal.await_prompt().splitlines()]
        assert max(map(len, lines)) <= columns
    assert any(re.search(r"Motor\.stopped  \(line_follower\.rscd:\d+\)", line) for line in lines)


def test_no_color(library: str) -> None:
    plain = Terminal(library, NO_COLOR="1", TERM="dumb")
    shown = plain.await_text("it is idle")
    plain.close()
    assert "\x1b[" not in shown


def test_a_dumb_terminal_is_no_hindrance(library: str) -> None:
    dumb = Terminal(library, TERM="dumb", NO_COLOR="1")
    dumb.await_prompt()
    dumb.type("distance free\r")
    assert "current = free" in dumb.await_prompt()
    dumb.type("quit\r")
    dumb.await_end()
    assert dumb.exit_code == 0
