"""Random servers of the courier's action, on both versions of ROS, and what must hold of its goals.

A server accepts or rejects a goal, carries it out for a random time, or until it is cancelled or
replaced, and heeds or ignores what is asked of it; goals may also run side by side, or queue up. It
wishes for other places, and wants goals or not, at random times. It writes when goals begin and end
into a file; the controller's event log says what the controller knew of that.
"""

from __future__ import annotations

import json
import random
import threading
import time
from bisect import bisect_left
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Any, TextIO

ENDS = ("response", "error", "cancelled")
GUARDED = ("place", "wanted", "go")
"""What goes through the courier's supervisor."""


class RandomServer:
    """What a server does with its goals; the time that it says is before what it does is seen."""

    def __init__(self, seed: int, log: Path, goals: int) -> None:
        self.random = random.Random(seed)
        self.left = goals
        self._log: TextIO = log.open("w")
        self._latest = 0
        self._running: set[int] = set()
        self._lock = threading.Lock()

    def tell(self, what: str, number: int) -> None:
        with self._lock:
            (self._running.discard if what == "end" else self._running.add)(number)
            self._log.write(f"{what} {number} {time.time()!r}\n")
            self._log.flush()

    def asked(self) -> int | None:
        """The number of a goal that has come, if it is to be accepted."""
        with self._lock:
            self.left -= 1
            self._latest += 1
            number = self._latest
            refuses = self.random.random() < (0.3 if self._running else 0.05)
        if refuses:
            return None
        self.tell("begin", number)
        return number

    def _is_first(self, number: int) -> bool:
        """Whether no goal runs that came before."""
        with self._lock:
            return min(self._running) >= number

    def carry_out(self, number: int, is_cancelled: Callable[[], bool]) -> str:
        """Carry out a goal until it ends: ``succeed``, ``abort`` or ``cancel``."""
        end = time.monotonic() + self.random.uniform(0.0, 0.05)
        heeds = self.random.random() < 0.7
        replaces = self.random.random() < 0.5
        queues = self.random.random() < 0.3
        while queues and not self._is_first(number):
            time.sleep(0.001)
        while time.monotonic() < end:
            if heeds and is_cancelled():
                return "cancel"
            if replaces and self._latest != number:
                return "abort"
            time.sleep(0.001)
        return self.random.choice(("succeed", "succeed", "abort"))

    def wishes(self, place: Callable[[float], Any], wanted: Callable[[bool], Any]) -> None:
        """Wish and want at random until enough goals have come; in the end nothing is wanted."""
        while self.left > 0:
            place(float(self.random.randint(0, 3)))
            wanted(self.random.random() < 0.8)
            time.sleep(self.random.uniform(0.0, 0.03))
        wanted(False)


@dataclass(frozen=True)
class Followed:
    """What happened: how often each event, how often a goal was replaced, when it was called over
    while a goal ran, and what else was wrong."""

    counts: dict[str, int]
    replaced: int
    early: tuple[str, ...]
    wrong: tuple[str, ...]


def followed(events: Path, goals: Path, crossing: float | None = 0.0) -> Followed:
    """Compare an event log with what the server says; whoever only listens may see the end of a goal
    after the begin of the next one, by so many seconds; None: until it has seen that, too."""
    lines = [line.split() for line in goals.read_text().splitlines()]
    begun = {int(number): float(at) for what, number, at in lines if what == "begin"}
    ended = {int(number): float(at) for what, number, at in lines if what == "end"}
    early: list[str] = []
    wrong = [f"goal {number} has not ended" for number in begun if number not in ended]
    order = sorted(begun, key=lambda number: begun[number])
    starts = [begun[number] for number in order]
    longest = max((ended.get(n, 0.0) - begun[n] for n in order), default=0.0)
    phase, counts, replaced = "idle", dict.fromkeys((*ENDS, "request", "cancel"), 0), 0
    seen = 0
    for line in events.read_text().splitlines():
        document = json.loads(line)
        kind, name = document["event"]["kind"], document["event"]["name"]
        if name != "go" or kind not in counts:
            continue
        seen += kind == "request"
        if document["outcome"] != "applied":
            wrong.append(f"{kind}: {document['outcome']}")
            continue
        counts[kind] += 1
        if kind in ENDS:
            if phase == "idle":
                wrong.append(f"{kind} while idle")
            at = document["time"] - 0.0005  # it is rounded
            first = bisect_left(starts, at - longest)
            last = seen if crossing is None else bisect_left(starts, at - crossing)
            running = [n for n in order[first:last] if ended.get(n, at + 1) > at + 0.001]
            early += [f"{kind} at {at!r} while goal {number} runs" for number in running]
            phase = "idle"
        elif kind == "request":
            if phase == "cancelling":
                wrong.append("request while cancelling")
            replaced += phase == "busy"
            phase = "busy"
        else:
            if phase != "busy":
                wrong.append(f"cancel while {phase}")
            phase = "cancelling"
    if phase != "idle":
        wrong.append(f"it is {phase} in the end")
    return Followed(counts, replaced, tuple(early), tuple(wrong))


def check(events: Path, goals: Path, count: int) -> None:
    """The log of who sends goals or passes them on tells right when they run, of which all sorts of
    end have come."""
    found = followed(events, goals)
    assert found.early + found.wrong == ()
    assert found.replaced > count / 20
    assert all(found.counts.values()), found.counts


def check_monitor(events: Path, goals: Path, crossing: float | None) -> None:
    """The log of a monitor, which may take what comes late for forbidden, and may not know what is
    cancelled or over then, but never takes an action for over while a goal runs."""
    found = followed(events, goals, crossing)
    assert found.early == ()
    assert all(found.counts.values()), found.counts


def check_order(events: Path) -> None:
    """The log of who follows servers that are killed: nothing happens that was not possible, and no
    goal is requested while one that was cancelled may go on."""
    phase = "idle"
    for line in events.read_text().splitlines():
        document = json.loads(line)
        kind, name = document["event"]["kind"], document["event"]["name"]
        if name != "go":
            continue
        assert document["outcome"] == "applied", document
        assert (kind, phase) != ("request", "cancelling"), document
        phase = {"request": "busy", "cancel": "cancelling", "feedback": phase}.get(kind, "idle")


def has_told(goals: Path, count: int) -> bool:
    """Whether a server has told so much of its goals."""
    return goals.is_file() and len(goals.read_text().splitlines()) >= count


def at_rest(state: dict[str, Any]) -> bool:
    """Whether a node of the courier shows that nothing is wanted any more, and no goal runs."""
    is_over = state["communications"]["go"] == "idle" and not state["variables"]["Desk.open"]
    return is_over and state["counters"]["mismatches"] == 0
