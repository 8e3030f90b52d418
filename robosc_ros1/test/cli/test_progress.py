"""The progress line: on terminals, after a while, and gone in the end."""

from __future__ import annotations

import io

from robosc.progress import ProgressLine


class Terminal(io.StringIO):
    """Text that says it is a terminal."""

    def isatty(self) -> bool:
        return True


def test_line_shows_how_far_it_is() -> None:
    terminal = Terminal()
    ProgressLine(terminal, after=0.0)("synthesis", 500, 1000)
    line = "synthesis [" + "#" * 15 + "." * 15 + "] 500 of at most 1,000"
    assert terminal.getvalue() == f"\r{line}"


def test_line_is_taken_away() -> None:
    terminal = Terminal()
    line = ProgressLine(terminal, after=0.0)
    line("synthesis", 5, 10)
    drawn = len(terminal.getvalue()) - 1
    line.clear()
    assert terminal.getvalue().endswith("\r" + " " * drawn + "\r")


def test_short_work_draws_nothing() -> None:
    terminal = Terminal()
    line = ProgressLine(terminal, after=3600.0)
    line("synthesis", 5, 10)
    line.clear()
    assert terminal.getvalue() == ""


def test_files_and_pipes_get_nothing() -> None:
    file = io.StringIO()
    line = ProgressLine(file, after=0.0)
    line("synthesis", 5, 10)
    line.clear()
    assert file.getvalue() == ""


def test_more_than_the_most_and_nothing_at_all_are_drawn_too() -> None:
    terminal = Terminal()
    ProgressLine(terminal, after=0.0)("synthesis", 20, 10)
    ProgressLine(terminal, after=0.0)("synthesis", 0, 0)
    assert "#" * 30 in terminal.getvalue()


def test_of_very_many_the_bar_counts_the_digits() -> None:
    terminal = Terminal()
    ProgressLine(terminal, after=0.0)("reachable states", 10**10, 10**20)
    assert "[" + "#" * 15 + "." * 15 + "] 10,000,000,000 of at most 10^20" in terminal.getvalue()
