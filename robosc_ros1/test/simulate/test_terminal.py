"""At a terminal: completion, lines as wide as it is, and the ways to leave."""

from __future__ import annotations

import io
import re
from collections.abc import Iterator

import pytest
from hypothesis import given
from hypothesis import strategies as st
from simulate.players import line_follower, session
from simulate.typed_terminal import Terminal

from robosc.simulate.script.render import Style, fitted
from robosc.simulate.script.run import follow_typing
from robosc.simulate.script.session import Session
from robosc.simulate.script.terminal import completions

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


@pytest.fixture(params=["readline", "prompt_toolkit"])
def library(request: pytest.FixtureRequest) -> str:
    name: str = request.param
    return name


@pytest.fixture
def terminal(library: str) -> Iterator[Terminal]:
    opened = Terminal(library)
    yield opened
    opened.close()


@pytest.mark.once
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


def test_control_c_gives_up_the_line_and_keeps_the_session(terminal: Terminal) -> None:
    terminal.await_prompt()
    terminal.type("distance free\r")
    terminal.await_prompt()
    terminal.type("stance")
    terminal.await_text("stance")
    terminal.interrupt("to leave, type quit or press Ctrl-D")
    terminal.await_text(">")
    terminal.type("goto DistanceSensor.current = free\r")
    terminal.await_text("it holds already")
    terminal.await_prompt()
    terminal.type("\x04")
    shown = terminal.await_end()
    assert terminal.exit_code == 0
    assert "Traceback" not in shown


def test_a_search_that_is_interrupted_leaves_the_session(monkeypatch: pytest.MonkeyPatch) -> None:
    playing = session(line_follower())
    lines = iter(["distance free", "goto Motor.stopped", "expect Motor.moving", "move", "quit"])

    def searching(condition: object) -> None:
        raise KeyboardInterrupt  # the key was pressed

    monkeypatch.setattr(playing.machine, "path", searching)
    out = io.StringIO()
    assert follow_typing(playing, lambda: next(lines), out, Style()) == 0
    assert "the search was interrupted\n" in out.getvalue()
    assert playing.history == ["distance.response(free)", "move.request"]


def test_lines_are_as_wide_as_the_terminal_is_now(terminal: Terminal) -> None:
    terminal.await_prompt()
    for columns in (60, 45, 200):
        terminal.resize(columns)
        terminal.type("show\r")
        terminal.await_text("LineFollower")
        lines = [PAINT.sub("", line) for line in terminal.await_prompt().splitlines()]
        assert max(map(len, lines)) <= columns
    assert any(re.search(r"Motor\.stopped  \(line_follower\.rscd:\d+\)", line) for line in lines)


@pytest.mark.slow
def test_no_color(library: str) -> None:
    plain = Terminal(library, NO_COLOR="1", TERM="dumb")
    shown = plain.await_text("it is idle")
    plain.close()
    assert "\x1b[" not in shown


@pytest.mark.slow
def test_a_dumb_terminal_is_no_hindrance(library: str) -> None:
    dumb = Terminal(library, TERM="dumb", NO_COLOR="1")
    dumb.await_prompt()
    dumb.type("distance free\r")
    assert "current = free" in dumb.await_prompt()
    dumb.type("quit\r")
    dumb.await_end()
    assert dumb.exit_code == 0
