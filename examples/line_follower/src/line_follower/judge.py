"""Judges a line follower by what is said on its topics alone. No ROS, and nothing of robosc.

Messages of different topics reach a listener in no certain order, and a command that was right
when it was sent may arrive after the news that makes it wrong. So a command that arrives at time t
counts as right if there was a moment between t - tolerance and t + tolerance at which it was
allowed; it is judged when that time has passed. On a busy machine messages wait for longer: how
late the observer itself was about that time is added to the tolerance.
"""

from __future__ import annotations

from collections import deque
from collections.abc import Callable, Iterator
from dataclasses import dataclass, field

__all__ = ["CLEAR", "RULES", "SILENCE", "Judge"]

CLEAR = 0.35
"""Metres from which the way counts as free."""

SILENCE = 0.5
"""Seconds without a measurement after which nobody knows what stands in front."""

ABOUT = 1.0
"""Seconds before and after a command in which it counts how late the observer was; more do not."""

RULES = {
    "move needs a free way": "moved although something stands in front",
    "move needs measurements": "moved although the distance sensor was silent",
    "move needs an idle grabber": "moved while grabbing",
    "stop needs a reason": "stopped although the way is free, measured, and nothing is grabbed",
    "grab needs an obstacle": "grabbed although the way is free",
    "grab needs a halted robot": "grabbed while moving",
    "light shows the line": "light switched against what the line detector says",
    "light is switched to change it": "light switched to what it shows already",
    "nothing is touched": "ran into an obstacle",
}


@dataclass(frozen=True)
class Moment:
    """What the topics have said up to one moment; None: nothing yet."""

    obstructed: bool | None = None
    silent: bool | None = None
    grabbing: bool = False
    line: bool | None = None
    moving: bool | None = None

    def but(self, **changes: bool) -> Moment:
        return Moment(**{**self.__dict__, **changes})


@dataclass(frozen=True)
class _Open:
    """A command that waits for its judgement."""

    time: float
    rule: str
    allowed: Callable[[Moment], bool]


@dataclass
class Judge:
    """Tell it what arrives, and when (any steady clock); it counts violations of each rule."""

    tolerance: float
    silence: float = SILENCE
    violations: dict[str, int] = field(default_factory=lambda: dict.fromkeys(RULES, 0))
    first: dict[str, float] = field(default_factory=dict)
    commands: int = 0
    latest: float = 0.0
    """How many seconds were added to the tolerance at most."""
    _late: deque[tuple[float, float]] = field(default_factory=deque)
    _history: deque[tuple[float, Moment]] = field(default_factory=lambda: deque([(0.0, Moment())]))
    _open: deque[_Open] = field(default_factory=deque)
    _light: bool | None = None
    _heard: float = float("inf")

    # --- what arrives ------------------------------------------------------------------------

    def distance(self, now: float, metres: float) -> None:
        self._note(now, obstructed=not metres >= CLEAR, silent=False)
        self._heard = now

    def line(self, now: float, seen: bool) -> None:
        self._note(now, line=seen)

    def velocity(self, now: float, speed: float, turn: float) -> None:
        moving = speed != 0.0 or turn != 0.0
        if moving:
            self._command(now, "move needs a free way", lambda m: m.obstructed is not True)
            self._command(now, "move needs measurements", lambda m: m.silent is not True)
            self._command(now, "move needs an idle grabber", lambda m: not m.grabbing)
        else:
            # Before the first measurement the way is not known to be free, and stopping is right.
            self._command(
                now,
                "stop needs a reason",
                lambda m: m.obstructed is not False or m.silent is True or m.grabbing,
            )
        self._note(now, moving=moving)

    def grab(self, now: float) -> None:
        # Judged by the moments before the goal: it is itself what makes the robot grab.
        self._command(now, "grab needs an obstacle", lambda m: m.obstructed is True)
        self._command(now, "grab needs a halted robot", lambda m: m.moving is False)
        self._note(now, grabbing=True)

    def grab_ended(self, now: float) -> None:
        self._note(now, grabbing=False)

    def light(self, now: float, on: bool) -> None:
        self._command(now, "light shows the line", lambda m: (m.line is not True) == on)
        if self._light == on:
            self._violate(now, "light is switched to change it")
        self._light = on

    def late(self, now: float, seconds: float) -> None:
        """What the observer does now it should have done so much earlier."""
        seconds = min(seconds, ABOUT)
        self.latest = max(self.latest, seconds)
        self._late.append((now, seconds))

    def bump(self, now: float) -> None:
        self._violate(now, "nothing is touched")

    # --- judgement ---------------------------------------------------------------------------

    def settle(self, now: float) -> None:
        """Judge the commands whose time has come; forget what no open command needs any more."""
        self._notice_silence(now)
        longest = self.tolerance + ABOUT
        while self._open and self._open[0].time + longest < now:
            case = self._open.popleft()
            if not any(case.allowed(moment) for moment in self._around(case.time)):
                self._violate(case.time, case.rule)
        oldest = (self._open[0].time if self._open else now) - longest
        while len(self._history) > 1 and self._history[1][0] < oldest:
            self._history.popleft()
        while self._late and self._late[0][0] < oldest:
            self._late.popleft()

    def _around(self, time: float) -> Iterator[Moment]:
        """All moments that lasted at some time within the tolerance around a time."""
        late = [seconds for at, seconds in self._late if abs(at - time) <= ABOUT]
        tolerance = self.tolerance + max(late, default=0.0)
        starts = [start for start, _ in self._history]
        ends = [*starts[1:], float("inf")]
        for (start, moment), end in zip(self._history, ends, strict=True):
            if end >= time - tolerance and start <= time + tolerance:
                yield moment

    def _note(self, now: float, **changes: bool) -> None:
        self._notice_silence(now)
        before = self._history[-1][1]
        after = before.but(**changes)
        if after != before:
            self._history.append((now, after))

    def _notice_silence(self, now: float) -> None:
        before = self._history[-1][1]
        if not before.silent and now - self._heard > self.silence:
            self._history.append((self._heard + self.silence, before.but(silent=True)))

    def _command(self, now: float, rule: str, allowed: Callable[[Moment], bool]) -> None:
        self.commands += 1
        self._open.append(_Open(now, rule, allowed))

    def _violate(self, time: float, rule: str) -> None:
        self.violations[rule] += 1
        self.first.setdefault(rule, time)
