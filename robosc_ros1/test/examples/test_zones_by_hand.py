"""The supervisor of examples/zones against a reading of its own: who may wait for whom."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from itertools import pairwise

from ros_support import EXAMPLES, Completed

LEFT, RIGHT = (1, 2, 3, 4, 5, 1), (5, 4, 6, 7, 8, 5)
ROUTES = [dict(pairwise(way)) for way in (LEFT, LEFT, RIGHT, RIGHT)]
HOMES = (1, 2, 6, 7)
AFTER = {"stands": "waits", "waits": "crosses", "crosses": "stands"}
State = tuple[tuple[int, str], ...]


def steps(state: State) -> Iterator[tuple[bool, State]]:
    """What may happen next, and whether the controller decides on it."""
    for number, (zone, phase) in enumerate(state):
        there = ROUTES[number][zone] if phase == "crosses" else zone
        yield phase == "waits", (*state[:number], (there, AFTER[phase]), *state[number + 1 :])


def is_safe(state: State) -> bool:
    held = [zone for zone, _ in state]
    held += [ROUTES[n][zone] for n, (zone, phase) in enumerate(state) if phase == "crosses"]
    return len(held) == len(set(held))


def reached(start: State, good: Callable[[State], bool]) -> set[State]:
    found, pending = {start}, [start]
    while pending:
        for _, after in steps(pending.pop()):
            if after not in found and good(after):
                found.add(after)
                pending.append(after)
    return found


def supervised(start: State) -> tuple[set[State], set[State]]:
    """The states without collisions, and those from which all can always come to stand."""
    safe = reached(start, is_safe)
    good, before = safe, set[State]()
    while good != before:
        before = good
        rest = {s for s in good if all(phase == "stands" for _, phase in s)}
        back: dict[State, list[State]] = {}
        for state in good:
            for _, after in steps(state):
                back.setdefault(after, []).append(state)
        pending = [*rest]
        while pending:
            for state in back.get(pending.pop(), ()):
                if state not in rest:
                    rest.add(state)
                    pending.append(state)
        good = {s for s in rest if all(by_grant or after in rest for by_grant, after in steps(s))}
    return safe, reached(start, good.__contains__)


def test_no_state_is_left_out_but_those_that_end_in_a_deadlock(
    robosc: Callable[..., Completed],
) -> None:
    safe, good = supervised(tuple((home, "stands") for home in HOMES))
    assert len(good) < len(safe)  # without collisions alone, they would block each other
    # Each place may be fresh or silent at any time.
    count = f"{len(good) * 2 ** len(HOMES):,} states"
    done = robosc("verify", str(EXAMPLES / "zones" / "zones.rscd"))
    assert done.returncode == 0, done.stderr
    assert done.stdout.startswith(f"Floor: {count}, ")
    assert "nonblocking: yes" in done.stdout
