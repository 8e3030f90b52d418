"""What a run of tests shows: what runs now, how long it may take, and what was left out."""

from __future__ import annotations

import threading
import time
from collections import Counter
from typing import Any

import costs
import pytest
from costs import Cost, function_of

__all__ = ["Progress", "Summary"]

GRANTED = 10.0
"""Seconds of tests that are thought to have taken as long as on the machine of ``costs.csv``."""
EVERY = 20.0
"""Seconds between two lines where the output is no terminal."""


class Summary:
    """A plugin of the process that reports: what was left out, and, for later runs, what it cost."""

    def __init__(self) -> None:
        self._costs: dict[str, Cost] = {}

    def pytest_runtest_logreport(self, report: Any) -> None:
        size = "slow" if "slow" in report.keywords else "quick"
        cost = self._costs.setdefault(function_of(report.nodeid), Cost(size))
        cost.seconds += report.duration
        if report.when == "teardown":
            cost.cases += 1
            cost.processor += dict(report.user_properties).get("processor", 0.0)

    def pytest_sessionfinish(self) -> None:
        whole = {function: cost for function, cost in self._costs.items() if cost.cases}
        costs.write(costs.LAST, costs.read(costs.LAST) | whole)

    def pytest_terminal_summary(self, terminalreporter: Any) -> None:
        """Nothing is left out silently."""
        skipped = {plain(r.nodeid): reason(r) for r in terminalreporter.stats.get("skipped", ())}
        reasons = Counter(skipped.values())
        if reasons:
            parts = "; ".join(f"{number} for {text}" for text, number in reasons.most_common())
            terminalreporter.write_line(f"left out, {sum(reasons.values())} in all: {parts}")


class Progress:
    """A plugin of the process that reports."""

    def __init__(self, reporter: Any, workers: int) -> None:
        self._reporter = reporter
        self._known = costs.read(costs.KEPT) | costs.read(costs.LAST)
        self._workers = workers
        self._awaited: dict[str, float] = {}
        self._running: dict[str, float] = {}  # since when
        self._start = self._shown = time.monotonic()
        self._done = self._number = 0
        self._passed_seconds = 0.0
        self._lock = threading.Lock()
        self._ended = threading.Event()
        reporter.showfspath = False
        if workers:
            # Else the tests' output is caught in this very process, and this with it.
            threading.Thread(target=self._tick, daemon=True).start()

    @pytest.hookimpl(optionalhook=True)
    def pytest_xdist_node_collection_finished(self, ids: list[str]) -> None:
        self._await(ids)

    def pytest_collection_finish(self, session: pytest.Session) -> None:
        self._await([item.nodeid for item in session.items])

    def _await(self, tests: list[str]) -> None:
        if not self._number and tests:
            self._awaited = {plain(test): costs.seconds_of(test, self._known) for test in tests}
            self._number = len(self._awaited)
            self._start = time.monotonic()

    def pytest_runtest_logstart(self, nodeid: str) -> None:
        with self._lock:
            self._running[plain(nodeid)] = time.monotonic()
        self._show()

    def pytest_runtest_logfinish(self, nodeid: str) -> None:
        test = plain(nodeid)
        with self._lock:
            self._running.pop(test, None)
            self._passed_seconds += self._awaited.pop(test, 0.0)
            self._done += 1

    def pytest_report_teststatus(self, report: Any) -> tuple[str, str, str] | None:
        """No letter for each test: failures are named at once."""
        if report.failed:
            self._line(f"FAILED {plain(report.nodeid)} ({report.when})")
            return ("failed" if report.when == "call" else "error"), "", ""
        if report.skipped and not hasattr(report, "wasxfail"):
            return "skipped", "", ""
        if report.passed and not hasattr(report, "wasxfail"):
            return ("passed" if report.when == "call" else ""), "", ""
        return None

    def pytest_sessionfinish(self) -> None:
        self._ended.set()
        self._clear()

    def _tick(self) -> None:
        while not self._ended.wait(1.0):
            self._show()

    def _show(self) -> None:
        with self._lock:
            now = time.monotonic()
            tty = self._reporter.isatty
            if now - self._shown < (0.2 if tty else EVERY) or not self._number:
                return
            self._shown = now
            text = self._text(now)
            if tty:
                width = self._reporter._tw.fullwidth - 1
                self._reporter.write(f"\r{text[:width]}\x1b[K", flush=True)
            else:
                self._reporter.write_line(text)

    def _text(self, now: float) -> str:
        # The first tests make what others use, and run for minutes: what they have run counts, too.
        running = sum(min(now - t, self._awaited.get(n, 0.0)) for n, t in self._running.items())
        left = sum(self._awaited.values()) - running
        # What is over tells how fast this machine is; a little is taken for granted at first.
        granted = GRANTED / max(self._workers, 1)
        pace = (now - self._start + granted) / (self._passed_seconds + running + GRANTED)
        minutes = left * pace / 60
        rest = f"{minutes:.0f} min" if minutes >= 1.5 else f"{60 * minutes:.0f} s"
        names = ", ".join(dict.fromkeys(short(test) for test in self._running))
        return f"{self._done} of {self._number} · about {rest} more · now {names or 'starting'}"

    def _clear(self) -> None:
        if self._reporter.isatty:
            self._reporter.write("\r\x1b[K", flush=True)

    def _line(self, text: str) -> None:
        with self._lock:
            self._clear()
            self._reporter.write_line(text)


def plain(nodeid: str) -> str:
    """The test as pytest takes it: side by side, pytest-xdist appends the group."""
    head, sign, group = nodeid.rpartition("@")
    return head if sign and "]" not in group and "/" not in group else nodeid


def short(test: str) -> str:
    return function_of(test).replace(".py::", ": ")


def reason(report: Any) -> str:
    text = report.longrepr[2] if isinstance(report.longrepr, tuple) else str(report.longrepr)
    return str(text).removeprefix("Skipped: ")
